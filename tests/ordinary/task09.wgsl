// Homing: go away first, then come back to the starting pose.
const TAU: f32 = 6.28318530718;

struct TaskState {
  home: vec3<f32>,
  farthest: f32,
  error: f32,
  phase: i32,
}

fn turn_difference(a: f32, b: f32) -> f32 {
  let d = fract(a - b + 0.5) - 0.5;
  return d;
}

fn homing_error(pose: vec3<f32>, home: vec3<f32>) -> f32 {
  let offset = pose.xy - home.xy;
  let angular = abs(turn_difference(pose.z, home.z)) * TAU;
  return sqrt(dot(offset, offset)) + 50.0 * angular;
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
  return TaskState(pose, 0.0, 0.0, 0);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
  var state = before;
  let error = homing_error(now.end, before.home);
  var reward = 0.0;
  switch before.phase {
    case 0: {
      let away = distance(now.end.xy, before.home.xy);
      reward = max(away - before.farthest, 0.0) / 100.0;
      state.farthest = max(state.farthest, away);
      if (away > 800.0 || now.step * 2u > cycles(episode)) {
        state.phase = 1;
      }
    }
    case 1: {
      reward = (before.error - error) / 100.0;
      if (error < 60.0) { state.phase = 2; }
    }
    default: {
      reward = 1.0;
    }
  }
  state.error = error;
  return Reward(reward, state);
}
