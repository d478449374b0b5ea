// What controllers and tasks get of the sensors, and where in a table of samples an object is found.

// Activations of the eight sensors of proximity, in [0, 1], and the readings of a user's sensors.
struct Readings {
    first: vec4<f32>,
    last: vec4<f32>,
    own: SensorReadings,
}

// Number of readings.
const INPUTS: u32 = 8u + OWN_READINGS;

// A sum of readings as an activation, clipped to 1.
fn activation(sum: u32, scale: f32) -> f32 {
    return min(f32(sum) * scale, 1.0f);
}

// The row of a table for a gap between the robot's rim and an object, mm.
fn row_of(world: u32, gap: f32) -> u32 {
    return u32(max((gap - worlds[world].nearest) * worlds[world].rows_per_mm, 0.0f));
}

// The bearing of a table for an object in the direction `to`, of which the inverse length is given. Tables count
// bearings clockwise, headings count the other way.
fn bearing_of(world: u32, heading: f32, to: vec2<f32>, inverse: f32) -> u32 {
    let clockwise = heading - direction_by(to, inverse);
    let share = clockwise - floor(clockwise);
    return min(u32(share * worlds[world].bearings_per_turn), worlds[world].bearings - 1u);
}

// The maximum of the eight activations.
fn highest(r: Readings) -> f32 {
    let a = max(max(r.first.x, r.first.y), max(r.first.z, r.first.w));
    let b = max(max(r.last.x, r.last.y), max(r.last.z, r.last.w));
    return max(a, b);
}

// The sum of all readings, each times its gene; gene `index` weighs the first.
fn weighed(episode: Episode, index: u32, r: Readings) -> f32 {
    var sum = gene(episode, index) * r.first.x;
    sum += gene(episode, index + 1u) * r.first.y;
    sum += gene(episode, index + 2u) * r.first.z;
    sum += gene(episode, index + 3u) * r.first.w;
    sum += gene(episode, index + 4u) * r.last.x;
    sum += gene(episode, index + 5u) * r.last.y;
    sum += gene(episode, index + 6u) * r.last.z;
    sum += gene(episode, index + 7u) * r.last.w;
    return plus_weighed(episode, index + 8u, r.own, sum);
}
