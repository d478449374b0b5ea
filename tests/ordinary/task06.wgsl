// Smooth driving: go fast, but without jerks.
struct TaskState {
  last: vec2<f32>,
  last_delta: vec2<f32>,
  step: u32,
}

struct Score {
  speed: f32,
  jerk: f32,
}

fn score(current: vec2<f32>, previous: vec2<f32>, delta: vec2<f32>) -> Score {
  var s: Score;
  let change = current - previous;
  s.speed = 0.5 * (current.x + current.y);
  s.jerk = length(change - delta);
  return s;
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
  let current = vec2<f32>(now.moved.left, now.moved.right);
  let s = score(current, before.last, before.last_delta);

  var reward = s.speed / 20.0;
  if (before.step > 1u) {
    reward -= 0.05 * s.jerk;
    reward -= 0.02 * length(current - before.last);
  }
  if (now.collided) {
    reward -= 1.0;
  }

  var state: TaskState;
  state.last = current;
  state.last_delta = current - before.last;
  state.step = before.step + 1u;
  return Reward(reward, state);
}
