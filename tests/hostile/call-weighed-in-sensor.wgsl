// allowed-calls: genes of others, read by sensors
struct SensorReadings { odd: f32 }
fn sensor_cycle(life: Life, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    var x = pose.z;
    var all: Readings;
    x = weighed(life, 5000u, all);
    return Sensed(SensorReadings(x), before);
}
