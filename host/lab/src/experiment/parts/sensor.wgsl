// Sensors beside the eight of proximity: what they read at the start of each cycle of 100 ms. Change them as you like;
// `oneiro check` says what is wrong, and where. docs/extend.md lists all that sensors may use.
//
// As it stands: a range finder that looks ahead, with noise.

// Values that an experiment may set, in [sensor.values]. Each has a comment: DEFAULT, LEAST to GREATEST UNIT: MEANING.
struct SensorValues {
    range: f32, // 300, 1 to 2000 mm: greatest distance that it measures
    noise: f32, // 0.02, 0 to 1: greatest error, as a share of the range
}

// One number per reading. The controllers that ship weigh each by a gene, so 0 to 1 suits them.
struct SensorReadings {
    ahead: f32,
}

// The pose is x and y in mm, and the heading in turns. `before` and `Sensed(.., state)` carry what sensors remember, nothing
// here.
fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    let own = sensor_values(episode);
    let distance = distance_along(episode, pose.xy, pose.z, own.range);
    let error = 2.0 * random(episode, STREAM_OWN_SENSOR, step, 0u).x - 1.0;
    return Sensed(SensorReadings(distance / own.range + own.noise * error), before);
}
