// Coverage: reward for every grid cell entered for the first time.

const GRID = 8u;
const CELL = 125.0;

struct TaskState {
    visited: vec2<u32>,
    count: u32,
}

fn cell_index(p: vec2<f32>) -> u32 {
    let c = clamp(vec2<i32>(floor(p / CELL)), vec2<i32>(0), vec2<i32>(i32(GRID) - 1));
    return u32(c.y) * GRID + u32(c.x);
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    var state: TaskState;
    let index = cell_index(pose.xy);
    state.visited[index / 32u] = 1u << (index % 32u);
    state.count = 1u;
    return state;
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var state = before;
    let index = cell_index(now.end.xy);
    let word = index / 32u;
    let bit = 1u << (index % 32u);

    var reward = 0.0;
    if ((state.visited[word] & bit) == 0u) {
        state.visited[word] |= bit;
        state.count += 1u;
        reward += 1.0;
    }
    if (now.collided) {
        reward -= 0.05;
    }
    return Reward(reward, state);
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
    return memory.count >= GRID * GRID;
}
