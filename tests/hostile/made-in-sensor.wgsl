// episode-as-given: sensors with other random numbers
alias L = Episode;

struct SensorReadings { odd: f32 }
fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    var x = pose.z;
    x = random(L(0u, vec2<u32>(step, 0u), 0u, 0u), STREAM_OWN_SENSOR, step, 0u).x;
    return Sensed(SensorReadings(x), before);
}
