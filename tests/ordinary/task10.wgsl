// Curvature penalty: cover ground while turning as little as possible.
const PI = 3.14159265;
const EPSILON = 1e-3;
const WEIGHT = 120.0;

struct TaskState {
  curvature: f32,
  path: f32,
}

fn wrapped(turns: f32) -> f32 {
  return turns - floor(turns + 0.5);
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
  return TaskState();
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
  let travel = length(now.end.xy - now.start.xy);
  let turn = wrapped(now.end.z - now.start.z) * 2.0 * PI;
  var curvature = 0.0;
  if (travel > EPSILON) {
    curvature = abs(turn) / travel;
  } else if (abs(turn) > 0.01) {
    curvature = 0.05;
  }
  var state = before;
  state.curvature = mix(before.curvature, min(curvature, 0.05), 0.1);
  state.path += travel;

  // clearance lets it turn without punishment close to walls
  let ahead = distance_along(episode, now.end.xy, now.end.z, 600.0);
  let freedom = smoothstep(100.0, 400.0, ahead);
  let penalty = WEIGHT * state.curvature * freedom;
  let reward = travel / 30.0 - penalty - select(0.0, 2.0, now.collided);
  return Reward(reward, state);
}
