// A compass with the sine and cosine of the heading, with a slow local
// disturbance like that of iron in the floor.

const TAU = 6.283185307;
const DISTURBANCE = 0.03; // turns

struct SensorReadings {
    compass_north: f32,
    compass_east: f32,
    compass_turns: f32,
}

fn declination(p: vec2<f32>) -> f32 {
    let waves = sin(p.x / 170.0) * cos(p.y / 230.0) + 0.5 * sin((p.x + p.y) / 90.0);
    return DISTURBANCE * waves / 1.5;
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    let heading = pose.z + declination(pose.xy);
    let angle = heading * TAU;
    let readings = SensorReadings(
        0.5 + 0.5 * cos(angle),
        0.5 + 0.5 * sin(angle),
        fract(heading),
    );
    return Sensed(readings, before);
}
