// Orbit a centre counter-clockwise at a fixed radius.
const TAU = 6.283185307;
const CENTRE = vec2f(0.0);
const RADIUS = 500.0;

struct TaskState {
  angle: f32,
  laps: i32,
  swept: f32,
}

fn bearing(p: vec2f) -> f32 {
  let d = p - CENTRE;
  return atan2(d.y, d.x);
}

fn wrap(a: f32) -> f32 {
  return a - TAU * round(a / TAU);
}

fn task_begin(episode: Episode, pose: vec3f) -> TaskState {
  return TaskState(bearing(pose.xy), 0, 0.0);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
  let angle = bearing(now.end.xy);
  let delta = wrap(angle - before.angle);
  let swept = before.swept + delta;
  let error = abs(length(now.end.xy - CENTRE) - RADIUS) / RADIUS;
  var reward = delta * pow(max(1.0 - error, 0.0), 2.0) * 10.0;

  let laps = i32(floor(swept / TAU));
  if (laps > before.laps) {
    reward += 2.0;
  } else if (laps < before.laps) {
    reward -= 2.0;
  }
  if (now.collided) { reward -= 0.2; }
  return Reward(reward, TaskState(angle, laps, swept));
}
