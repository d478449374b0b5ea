// allowed-calls: genes of others, read by sensors
struct SensorReadings { odd: f32 }
fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    var x = pose.z;
    var all: Readings;
    x = weighed(episode, 5000u, all);
    return Sensed(SensorReadings(x), before);
}
