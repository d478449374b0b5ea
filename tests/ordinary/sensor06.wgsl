// Averaged history: the last four front distances, their mean, and a slow average.
const LIMIT = 1000.0;

struct SensorState {
  history: vec4<f32>,
  slow: f32,
  count: u32,
}

struct SensorReadings {
  history_mean: f32,
  history_trend: f32,
  history_slow: f32,
  history_spread: f32,
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
  var state = before;
  let value = distance_along(episode, pose.xy, pose.z, LIMIT) / LIMIT;
  if (before.count == 0u) {
    state.history = vec4<f32>(value);
    state.slow = value;
  }
  state.history[state.count % 4u] = value;
  state.count += 1u;
  state.slow = mix(state.slow, value, 0.05);

  let mean = dot(state.history, vec4<f32>(0.25));
  var variance = 0.0;
  for (var i = 0u; i < 4u; i += 1u) {
    let e = state.history[i] - mean;
    variance += e * e;
  }
  variance /= 4.0;

  var readings: SensorReadings;
  readings.history_mean = saturate(mean);
  readings.history_trend = clamp(0.5 + 2.0 * (value - mean), 0.0, 1.0);
  readings.history_slow = saturate(state.slow);
  readings.history_spread = saturate(2.0 * sqrt(variance));
  return Sensed(readings, state);
}
