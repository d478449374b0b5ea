// History of the distance ahead: the mean and the spread of the last eight,
// and whether the wall is coming nearer.

const LENGTH = 8u;
const AHEAD = 400.0;

struct SensorReadings {
    history_mean: f32,
    history_spread: f32,
    history_trend: f32,
}

struct SensorState {
    older: vec4<f32>,
    newer: vec4<f32>,
    filled: u32,
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    let ahead = distance_along(episode, pose.xy, pose.z, AHEAD) / AHEAD;

    // Shift everything by one.
    var state: SensorState;
    state.older = vec4<f32>(before.older.yzw, before.newer.x);
    state.newer = vec4<f32>(before.newer.yzw, ahead);
    state.filled = min(before.filled + 1u, LENGTH);

    var values = array<f32, LENGTH>();
    for (var i = 0u; i < 4u; i++) {
        values[i] = state.older[i];
        values[4u + i] = state.newer[i];
    }

    var sum = 0.0;
    var squares = 0.0;
    for (var i = 0u; i < LENGTH; i++) {
        if (i + state.filled < LENGTH) { continue; }
        sum += values[i];
        squares += values[i] * values[i];
    }
    let n = f32(state.filled);
    let mean = sum / n;
    let spread = sqrt(max(squares / n - mean * mean, 0.0));
    let trend = select(0.0, ahead - values[LENGTH - state.filled], state.filled > 1u);
    return Sensed(SensorReadings(saturate(mean), saturate(2.0 * spread), 0.5 + 0.5 * clamp(trend, -1.0, 1.0)), state);
}
