// Odometry: dead reckoning from the pose differences, with drift, in the
// frame of the first pose.

const TAU: f32 = 6.28318530718;
const SCALE: f32 = 1000.0;
const SLIP: f32 = 0.04;
const TURN_SLIP: f32 = 0.02;

struct SensorReadings {
    odometer_x: f32,
    odometer_y: f32,
    odometer_path: f32,
}

struct SensorState {
    last: vec3<f32>,
    estimate: vec3<f32>,
    path: f32,
}

fn rotate(v: vec2<f32>, turns: f32) -> vec2<f32> {
    let c = cos(turns * TAU);
    let s = sin(turns * TAU);
    return mat2x2<f32>(c, s, -s, c) * v;
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    var state = before;
    if (step > 0u) {
        let r = random(episode, STREAM_OWN_SENSOR, step, 0u) - 0.5;
        let local = rotate(pose.xy - state.last.xy, -state.last.z);
        let turned = fract(pose.z - state.last.z + 0.5) - 0.5;

        let measured = local * (1.0 + SLIP * 2.0 * r.x);
        let moved = rotate(measured, state.estimate.z);
        let heading = fract(state.estimate.z + turned * (1.0 + TURN_SLIP * 2.0 * r.y));
        state.estimate = vec3<f32>(state.estimate.xy + moved, heading);
        state.path += length(measured);
    }
    state.last = pose;

    let place = 0.5 + 0.5 * state.estimate.xy / SCALE;
    let path = state.path % SCALE / SCALE;
    return Sensed(SensorReadings(saturate(place.x), saturate(place.y), path), state);
}
