// What controllers and tasks get of a forager's sensors.

// Readings in [0, 1] of four sensors of proximity and eight of light, by their bearings; 1 if the robot carries food; and the
// readings of a user's sensors.
struct Readings {
    near_left_17: f32,
    near_left_50: f32,
    near_right_50: f32,
    near_right_17: f32,
    light_left_17: f32,
    light_left_50: f32,
    light_right_50: f32,
    light_right_17: f32,
    light_left_90: f32,
    light_left_150: f32,
    light_right_150: f32,
    light_right_90: f32,
    carries: f32,
    own: SensorReadings,
}

// Number of readings.
const INPUTS: u32 = 13u + OWN_READINGS;

// All readings before and after the sensors' noise.
struct Seen {
    real: Readings,
    perceived: Readings,
}

fn sense(episode: Episode, step: u32, pose: vec3<f32>, carries: bool, custom: SensorReadings) -> Seen {
    let world = episode.world;
    let distances = wall_distances(world, pose);
    let curve = vec4<f32>(
        on_curve(world, distances.x), on_curve(world, distances.y),
        on_curve(world, distances.z), on_curve(world, distances.w),
    );
    let lamp = lamp_of(world);
    var ahead = vec4<f32>(0.0f);
    var behind = vec4<f32>(0.0f);
    if (lamp.shines > 0.0f) {
        ahead = lamp_light(world, 0u, pose, vec2<f32>(lamp.x, lamp.y));
        behind = lamp_light(world, 1u, pose, vec2<f32>(lamp.x, lamp.y));
    }
    let ambient = sensing_of(world).ambient;
    let real = as_readings(
        curve, clamp(ahead + ambient, vec4<f32>(0.0f), vec4<f32>(1.0f)),
        clamp(behind + ambient, vec4<f32>(0.0f), vec4<f32>(1.0f)), carries, custom,
    );
    let perceived = as_readings(
        near_readings(episode, step, distances), light_readings(episode, step, 0u, ahead), light_readings(episode, step, 1u, behind),
        carries, custom,
    );
    return Seen(real, perceived);
}

// What a sensor of proximity reads at a distance without noise.
fn on_curve(world: u32, distance: f32) -> f32 {
    let sensing = sensing_of(world);
    var reading = 0.0f;
    if (distance < sensing.sight) {
        let entry = u32(max(distance * sensing.entries_per_mm, 0.0f));
        let cell = curve_of(world, entry / 2u);
        reading = select(cell.next_reading, cell.reading, entry % 2u == 0u);
    }
    return reading;
}

fn as_readings(near: vec4<f32>, ahead: vec4<f32>, behind: vec4<f32>, carries: bool, custom: SensorReadings) -> Readings {
    return Readings(
        near.x, near.y, near.z, near.w, ahead.x, ahead.y, ahead.z, ahead.w, behind.x, behind.y, behind.z, behind.w,
        select(0.0f, 1.0f, carries), custom,
    );
}

// The maximum reading of proximity.
fn highest(r: Readings) -> f32 {
    return max(max(r.near_left_17, r.near_left_50), max(r.near_right_50, r.near_right_17));
}

// The sum of all readings, each times its gene; gene `index` weighs the first.
fn weighed(episode: Episode, index: u32, r: Readings) -> f32 {
    var sum = gene(episode, index) * r.near_left_17;
    sum += gene(episode, index + 1u) * r.near_left_50;
    sum += gene(episode, index + 2u) * r.near_right_50;
    sum += gene(episode, index + 3u) * r.near_right_17;
    sum += gene(episode, index + 4u) * r.light_left_17;
    sum += gene(episode, index + 5u) * r.light_left_50;
    sum += gene(episode, index + 6u) * r.light_right_50;
    sum += gene(episode, index + 7u) * r.light_right_17;
    sum += gene(episode, index + 8u) * r.light_left_90;
    sum += gene(episode, index + 9u) * r.light_left_150;
    sum += gene(episode, index + 10u) * r.light_right_150;
    sum += gene(episode, index + 11u) * r.light_right_90;
    sum += gene(episode, index + 12u) * r.carries;
    return plus_weighed(episode, index + 13u, r.own, sum);
}
