// No sensors besides the eight of proximity.

const OWN_READINGS: u32 = 0u;

// No struct is empty.
struct SensorReadings {
    unused: u32,
}

struct SensorState {
    unused: u32,
}

fn sensor_begin(episode: Episode, pose: vec3<f32>) -> SensorState {
    return SensorState(0u);
}

fn sensor_kept(memory: SensorState) -> SensorState {
    return memory;
}

fn sensors_read(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    return Sensed(SensorReadings(0u), before);
}

fn plus_weighed(episode: Episode, index: u32, custom: SensorReadings, sum: f32) -> f32 {
    return sum;
}
