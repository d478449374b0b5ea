// Gyro and speedometer with bias drift, low-pass filtered.

const TAU = 6.2831853;
const TOP_SPEED = 15.0;   // mm per cycle
const TOP_TURN = 0.02;    // turns per cycle
const SMOOTHING = 0.3;

struct SensorReadings {
    gyro_rate: f32,
    speed_forward: f32,
    speed_stalled: f32,
}

struct SensorState {
    pose: vec3<f32>,
    rate: f32,
    speed: f32,
    bias: f32,
    still: u32,
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    var state = before;
    let old = select(before.pose, pose, step == 0u);
    let moved = pose.xy - old.xy;
    let forward = vec2<f32>(cos(old.z * TAU), sin(old.z * TAU));
    let speed = dot(moved, forward);
    var turned = (pose.z - old.z) % 1.0;
    if (turned > 0.5) { turned -= 1.0; }
    if (turned < -0.5) { turned += 1.0; }

    let r = random(episode, STREAM_OWN_SENSOR, step, 0u) * 2.0 - 1.0;
    state.bias = clamp(state.bias + 0.0001 * r.x, -0.002, 0.002);
    state.rate = mix(state.rate, turned + state.bias, SMOOTHING);
    state.speed = mix(state.speed, speed, SMOOTHING);
    state.still = select(0u, state.still + 1u, length(moved) < 0.1);
    state.pose = pose;

    let readings = SensorReadings(
        saturate(0.5 + 0.5 * state.rate / TOP_TURN),
        saturate(0.5 + 0.5 * state.speed / TOP_SPEED),
        1.0 - exp2(-f32(state.still) / 10.0),
    );
    return Sensed(readings, state);
}
