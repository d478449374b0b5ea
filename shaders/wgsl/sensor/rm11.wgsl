// Inputs of EvoStick's network from the reference model RM1.1.

struct Given {
    prox_first: vec4<f32>,
    prox_last: vec4<f32>,
    light_first: vec4<f32>,
    light_last: vec4<f32>,
    ground: vec3<f32>,
    neighbours: f32,
    attraction: vec4<f32>,
}

fn given_to(episode: Episode, step: u32, pose: vec3<f32>) -> Given {
    let at = vec2<f32>(pose.x, pose.y);
    let heading = cosine_sine(pose.z);
    let near = proximity(episode, step, at, heading);
    let bright = brightness(episode, step, at, pose.z);
    let all = heard(episode, step, heading);
    let length = root(squared_length(all.attraction));
    // The attraction is shortened to 2 / (1 + e^-length) - 1, which is near half of it if it is short.
    let short = select(0.5f, (2.0f * logistic(length) - 1.0f) * reciprocal(max(length, 0x1p-10f)), length > 0x1p-10f);
    return Given(
        near.first, near.last, bright.first, bright.last,
        grounds(episode, step, floor_by_vote(episode, step, at, heading)),
        neighbours_of(all.number),
        quarters(short * all.attraction),
    );
}

// 0 for black and 1 for white; on any other floor each sensor gives a different number.
fn grounds(episode: Episode, step: u32, floor: f32) -> vec3<f32> {
    if (floor != 0.5f) {
        return vec3<f32>(floor);
    }
    let words = random_words(episode.key, STREAM_SENSOR, step, GREY_BLOCK);
    let left_and_middle = numbers(episode.world, REFERENCE_CELL + 2u);
    let right = numbers(episode.world, REFERENCE_CELL + 3u);
    return vec3<f32>(
        share_of(left_and_middle.x + left_and_middle.y * nearly_normal(words.x)),
        share_of(left_and_middle.z + left_and_middle.w * nearly_normal(words.y)),
        share_of(right.x + right.y * nearly_normal(words.z)),
    );
}
