// The homing robot's sensors beside infra-red: light in front and behind, the brightness of the floor, and the battery
// (Floreano and Mondada 1996). docs/classics/homing.md has the sources.

struct SensorValues {
    lamp: f32, // 1, 0 to 1: 1 if the lamp is on
    decay: f32, // 0.003532, 0 to 1 per mm: of the light; the far corner of the field reads 0.1 towards the lamp
    height: f32, // 250, 0 to 1000 mm: of the lamp, above the corner at (0, 0)
    radius: f32, // 80, 1 to 1000 mm: of the charging patch, a quarter of a disc around that corner
    full: f32, // 200, 1 to 100000 cycles: that a full battery lasts
}

struct SensorReadings {
    light_front: f32,
    light_back: f32,
    floor: f32,
    battery: f32,
}

struct SensorState {
    // cycles
    left: f32,
}

fn sensor_begin(episode: Episode, pose: vec3<f32>) -> SensorState {
    return SensorState(sensor_values(episode).full);
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    let own = sensor_values(episode);
    let squared = pose.x * pose.x + pose.y * pose.y;
    let strength = own.lamp * exponential(-own.decay * root(squared + own.height * own.height));
    // Turns from the heading to the lamp, -0.5 to 0.5.
    let bearing = direction(vec2<f32>(-pose.x, -pose.y)) - pose.z;
    let aside = abs(bearing - floor(bearing + 0.5f));
    let front = strength * max(1.0f - 4.0f * aside, 0.0f);
    let back = strength * max(1.0f - 4.0f * (0.5f - aside), 0.0f);
    let is_charging = squared < own.radius * own.radius;
    let left = select(max(before.left - 1.0f, 0.0f), own.full, is_charging);
    let brightness = select(1.0f, 0.0f, is_charging);
    return Sensed(SensorReadings(front, back, brightness, left * reciprocal(own.full)), SensorState(left));
}
