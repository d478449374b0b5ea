// allowed-calls: a gene of another, read by sensors
struct SensorReadings { odd: f32 }
fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    var x = pose.z;
    x = gene(episode, 64u * 99u);
    return Sensed(SensorReadings(x), before);
}
