// Inputs of EvoStick's network from the reference model RM1.2.

struct Given {
    prox: vec4<f32>,
    light: vec4<f32>,
    ground: f32,
    neighbours: f32,
    attraction: vec4<f32>,
}

// There is light in the direction of the sum of all readings, if one is greater than this.
const BRIGHT: f32 = 0.2f;

fn given_to(episode: Episode, step: u32, pose: vec3<f32>) -> Given {
    let at = vec2<f32>(pose.x, pose.y);
    let heading = cosine_sine(pose.z);
    let all = heard(episode, step, heading);
    return Given(
        quarters(nearness(proximity(episode, step, at, heading))),
        quarters(toward_light(brightness(episode, step, at, pose.z))),
        ground_given(episode, step, floor_by_vote(episode, step, at, heading)),
        neighbours_of(all.number),
        quarters(all.attraction),
    );
}

// The sum of the readings of proximity, at most 1 long.
fn nearness(ring: Ring) -> vec2<f32> {
    let sum = ring_sum(ring);
    let squared = squared_length(sum);
    return select(1.0f, reciprocal_root(max(squared, 1.0f)), squared > 1.0f) * sum;
}

fn toward_light(ring: Ring) -> vec2<f32> {
    let most = max(ring.first, ring.last);
    let brightest = max(max(most.x, most.y), max(most.z, most.w));
    let sum = ring_sum(ring);
    let inverse = reciprocal_root(max(squared_length(sum), 0x1p-60f));
    return select(0.0f, inverse, brightest > BRIGHT) * sum;
}

// 0 for black and 1 for white; any other floor gives another number.
fn ground_given(episode: Episode, step: u32, floor: f32) -> f32 {
    if (floor != 0.5f) {
        return floor;
    }
    let words = random_words(episode.key, STREAM_SENSOR, step, GREY_BLOCK);
    let grey = numbers(episode.world, REFERENCE_CELL + 2u);
    return share_of(grey.x + grey.y * nearly_normal(words.x));
}
