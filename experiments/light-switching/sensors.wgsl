// The robot's sensors beside infra-red: the lamp to its left, in front and to its right, and a linear camera that sees the black stripe on
// the wall over the switch, in three fields (Floreano and Urzelai 2000). docs/classics/light-switching.md has what is ours.

struct SensorValues {
    decay: f32, // 0.003, 0 to 1 per mm: of the lamp's light
    view: f32, // 0.1, 0.001 to 0.5 turns: that the camera sees, in three equal fields
    stripe: f32, // 90, 1 to 1000 mm: half of the stripe's length
}

struct SensorReadings {
    light_left: f32,
    light_front: f32,
    light_right: f32,
    stripe_left: f32,
    stripe_front: f32,
    stripe_right: f32,
}

struct SensorState {
    // 1 once the robot has been on the switch
    on: u32,
}

fn sensor_begin(episode: Episode, pose: vec3<f32>) -> SensorState {
    return SensorState(0u);
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    let own = sensor_values(episode);
    let at = pose.xy;
    let on = switched(episode, before.on, at);
    let lamp = arena_light(episode, 0u).place - at;
    let strength = f32(on) * exponential(-own.decay * length(lamp));
    let to_lamp = direction(lamp) - pose.z;
    // The stripe is on the wall through the switch's middle, so that it looks narrow from aside.
    let stripe = arena_patch(episode, 0u).place - at;
    let far = max(length(stripe), 1.0);
    let half = min(own.stripe * abs(stripe.x) / (far * far) / 6.2831855, 0.25);
    let to_stripe = direction(stripe) - pose.z;
    let field = own.view / 3.0;
    let readings = SensorReadings(
        strength * facing(to_lamp - 0.125), strength * facing(to_lamp), strength * facing(to_lamp + 0.125),
        covered(to_stripe - field, half, field), covered(to_stripe, half, field), covered(to_stripe + field, half, field),
    );
    return Sensed(readings, SensorState(on));
}

fn switched(episode: Episode, before: u32, at: vec2<f32>) -> u32 {
    return select(before, 1u, on_patch(episode, 0u, at));
}

// 1 where a light is straight ahead of a sensor, 0 from a quarter of a turn on.
fn facing(bearing: f32) -> f32 {
    return max(1.0 - 4.0 * abs(bearing - round(bearing)), 0.0);
}

// The fraction of a field of the camera that something covers which lies in a direction, and as far to both sides.
fn covered(bearing: f32, half: f32, field: f32) -> f32 {
    let middle = bearing - round(bearing);
    let start = max(middle - half, -0.5 * field);
    let end = min(middle + half, 0.5 * field);
    return clamp((end - start) / field, 0.0, 1.0);
}
