// Figure eight around two pylons, alternating direction of rotation.
const PYLON_A = vec2<f32>(-350.0, 0.0);
const PYLON_B = vec2<f32>(350.0, 0.0);
const TAU = 6.2831853;

struct TaskState {
  swept: f32,
  side: i32,
  loops: u32,
  quality: f32,
}

fn cross2(a: vec2<f32>, b: vec2<f32>) -> f32 {
  return a.x * b.y - a.y * b.x;
}

fn swept_angle(centre: vec2<f32>, start: vec2<f32>, end: vec2<f32>) -> f32 {
  let a = start - centre;
  let b = end - centre;
  return atan2(cross2(a, b), dot(a, b));
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
  return TaskState(0.0, select(1, -1, pose.x < 0.0), 0u, 0.0);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
  var state = before;
  let left_side = before.side < 0;
  let centre = select(PYLON_B, PYLON_A, left_side);
  let direction = f32(before.side);
  let angle = swept_angle(centre, now.start.xy, now.end.xy) * direction;
  state.swept += angle;

  let r = distance(now.end.xy, centre);
  let fit = 1.0 - smoothstep(50.0, 300.0, abs(r - 350.0));
  state.quality = 0.95 * state.quality + 0.05 * fit;
  var reward = 3.0 * angle * fit;

  if (state.swept >= TAU * 0.9) {
    state.swept = 0.0;
    state.side = -state.side;
    state.loops++;
    reward += 4.0 * state.quality;
  }
  if (now.collided) { reward -= 0.5; }
  return Reward(reward, state);
}
