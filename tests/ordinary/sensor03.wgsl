// Odometry: integrates noisy displacement since the first step.
struct SensorReadings {
  odo_x: f32,
  odo_y: f32,
  odo_heading: f32,
  odo_speed: f32,
}

struct SensorState {
  last: vec3<f32>,
  estimate: vec3<f32>,
  started: u32,
}

const SCALE = 1000.0;
const SLIP = 0.05;

fn rotate(v: vec2<f32>, turns: f32) -> vec2<f32> {
  let a = turns * 6.2831853;
  let m = mat2x2<f32>(cos(a), sin(a), -sin(a), cos(a));
  return m * v;
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
  var state = before;
  if (state.started == 0u) {
    state.last = pose;
    state.started = 1u;
  }
  let noise = random(episode, STREAM_OWN_SENSOR, step, 0u) * 2.0 - 1.0;
  let local = rotate(pose.xy - state.last.xy, -state.last.z);
  let turned = fract(pose.z - state.last.z + 0.5) - 0.5;
  let measured = local * (vec2<f32>(1.0) + SLIP * noise.xy);
  state.estimate = vec3<f32>(
    state.estimate.xy + rotate(measured, state.estimate.z),
    fract(state.estimate.z + turned * (1.0 + SLIP * noise.z)));
  state.last = pose;

  let p = clamp(state.estimate.xy / (2.0 * SCALE) + 0.5, vec2<f32>(0.0), vec2<f32>(1.0));
  let speed = clamp(length(measured) / 40.0, 0.0, 1.0);
  return Sensed(SensorReadings(p.x, p.y, state.estimate.z, speed), state);
}
