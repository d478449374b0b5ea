// Shared by all kernels that simulate one robot an episode: the episode, its start, and its trace.

// The part of a trace line that all robots have: the pose at the start of a cycle, the action, and the reward.
struct Record {
    x: f32,
    y: f32,
    heading: f32,
    // where the readings are from: the pose, or where noise or age displaces it to
    seen_x: f32,
    seen_y: f32,
    // outputs of the controller, and signed wheel speeds as fractions of the maximum
    left: f32,
    right: f32,
    speed_left: f32,
    speed_right: f32,
    collided: f32,
    reward: f32,
    fitness: f32,
}

// One line of a trace. The details, such as sensor readings, depend on the robot.
struct Line {
    record: Record,
    details: Details,
}

@group(0) @binding(6) var<storage, read_write> state: array<EpisodeState>;
@group(0) @binding(8) var<storage, read_write> trace: array<Line>;

// An episode: its world, the key of its random numbers, the index of its first gene, and the number of its trial.
struct Episode {
    world: u32,
    key: vec2<u32>,
    genes: u32,
    trial: u32,
}

// Where an episode starts: x and y in mm, heading in turns.
fn first_pose(episode: Episode) -> vec3<f32> {
    if (worlds[episode.world].random_start != 0u) {
        return random_pose(episode);
    }
    return vec3<f32>(worlds[episode.world].start_x, worlds[episode.world].start_y, worlds[episode.world].start_heading);
}

// A place in the zone that random starts are drawn from, uniform over it.
fn place_in_zone(world: u32, u: vec4<f32>) -> vec2<f32> {
    let corner = vec2<f32>(worlds[world].zone_x, worlds[world].zone_y);
    let size = vec2<f32>(worlds[world].zone_width, worlds[world].zone_height);
    if (worlds[world].zone_is_round != 0u) {
        return corner + root(size.x + u.x * size.y) * cosine_sine(u.y);
    }
    return vec2<f32>(corner.x + u.x * size.x, corner.y + u.y * size.y);
}

// A free pose, uniform over the zone of starts and all headings. Of 64 draws none being free leaves the
// world's own free pose, found when the world was made.
fn random_pose(episode: Episode) -> vec3<f32> {
    let world = episode.world;
    var pose = vec3<f32>(worlds[world].start_x, worlds[world].start_y, worlds[world].start_heading);
    for (var draw = 0u; draw < 64u; draw++) {
        let u = units(random_words(episode.key, STREAM_START, 0u, draw));
        let at = place_in_zone(world, u);
        if (!touches(world, at)) {
            pose = vec3<f32>(at, u.z);
            break;
        }
    }
    return pose;
}
