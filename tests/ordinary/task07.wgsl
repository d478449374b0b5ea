// Patrol: four posts; the longer a post was left alone, the more it pays.
const POSTS = array<vec2<f32>, 4>(
  vec2<f32>(-500.0, -500.0),
  vec2<f32>(500.0, -500.0),
  vec2<f32>(500.0, 500.0),
  vec2<f32>(-500.0, 500.0),
);
const NEAR = 150.0;
const SATURATION = 200.0;

struct TaskState {
  age: vec4<f32>,
  rounds: vec4<u32>,
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
  let r = random(episode, STREAM_TASK, 0u, 0u);
  return TaskState(r * SATURATION * 0.5, vec4<u32>(0u));
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
  var state = before;
  var posts = POSTS;
  state.age += vec4<f32>(1.0);
  var reward = 0.0;
  for (var i = 0; i < 4; i++) {
    if (distance(now.end.xy, posts[i]) < NEAR) {
      reward += min(state.age[i] / SATURATION, 1.0);
      if (state.age[i] > 50.0) {
        state.rounds[i] += 1u;
      }
      state.age[i] = 0.0;
    }
  }
  let neglected = max(max(state.age.x, state.age.y), max(state.age.z, state.age.w));
  reward -= 0.01 * smoothstep(SATURATION, 3.0 * SATURATION, neglected);
  return Reward(reward, state);
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
  return all(memory.rounds >= vec4<u32>(10u));
}
