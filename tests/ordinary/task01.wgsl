// Coverage: visit as many cells of an 8 x 8 grid as possible.
const CELL: f32 = 250.0;
const GRID: i32 = 8;

struct TaskState {
  cells: vec2<u32>,
  visited: u32,
}

fn cell_index(p: vec2<f32>) -> i32 {
  let c = vec2<i32>(floor(p / CELL)) + vec2<i32>(GRID / 2);
  if (any(c < vec2<i32>(0)) || any(c >= vec2<i32>(GRID))) {
    return -1;
  }
  return c.y * GRID + c.x;
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
  var state: TaskState;
  let index = cell_index(pose.xy);
  if (index >= 0) {
    state.cells[u32(index) / 32u] |= 1u << (u32(index) % 32u);
    state.visited = 1u;
  }
  return state;
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
  var state = before;
  var reward = -0.001;
  let index = cell_index(now.end.xy);
  if (index >= 0) {
    let word = u32(index) / 32u;
    let bit = 1u << (u32(index) % 32u);
    if ((state.cells[word] & bit) == 0u) {
      state.cells[word] |= bit;
      state.visited++;
      reward += 1.0;
    }
  }
  if (now.collided) {
    reward -= 0.1;
  }
  return Reward(reward, state);
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
  return countOneBits(memory.cells.x) + countOneBits(memory.cells.y) == 64u;
}
