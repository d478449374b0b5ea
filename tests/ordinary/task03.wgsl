// Energy: a battery that drains with motor effort and recharges at the dock.
const DOCK = vec2<f32>(0.0, 0.0);
const DOCK_RADIUS = 180.0;
const IDLE_COST = 0.0005;

struct TaskState {
  charge: f32,
  travelled: f32,
  docked: u32,
}

fn effort(m: Motion) -> f32 {
  return 0.5 * (m.left * m.left + m.right * m.right);
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
  return TaskState(1.0, 0.0, 0u);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
  var state = before;
  let moved = distance(now.start.xy, now.end.xy);
  state.travelled += moved;
  state.charge -= IDLE_COST + 0.00001 * effort(now.moved);

  let at_dock = distance(now.end.xy, DOCK) < DOCK_RADIUS;
  if (at_dock) {
    state.charge += 0.02;
    state.docked += 1u;
  }
  state.charge = clamp(state.charge, 0.0, 1.0);

  let hunger = 1.0 - smoothstep(0.1, 0.5, state.charge);
  let work = moved / 50.0;
  var reward = mix(work, f32(at_dock), hunger);
  if (state.charge <= 0.0) {
    reward -= 10.0;
  }
  return Reward(reward, state);
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
  return memory.charge <= 0.0;
}
