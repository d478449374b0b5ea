// Visit the four corners in any order; each counts once, all four end the episode.
const CORNER_COUNT: u32 = 4u;
const ALL_CORNERS: u32 = (1u << CORNER_COUNT) - 1u;
const REACH: f32 = 130.0;
const CORNERS = array<vec2<f32>, 4>(
    vec2<f32>(0.0, 0.0),
    vec2<f32>(1000.0, 0.0),
    vec2<f32>(1000.0, 1000.0),
    vec2<f32>(0.0, 1000.0)
);

struct TaskState {
    visited: u32,
    last: i32,
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return TaskState(0u, -1);
}

fn corner_near(position: vec2<f32>) -> i32 {
    var corners = CORNERS;
    for (var i = 0u; i < CORNER_COUNT; i++) {
        if (distance(corners[i], position) < REACH) {
            return i32(i);
        }
    }
    return -1;
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var state = before;
    var reward = 0.0;
    let corner = corner_near(now.end.xy);
    if (corner >= 0) {
        let bit = 1u << u32(corner);
        if ((state.visited & bit) == 0u) {
            state.visited |= bit;
            reward = f32(countOneBits(state.visited)) / f32(CORNER_COUNT);
            if (state.visited == ALL_CORNERS) {
                let remaining = 1.0 - f32(now.step) / f32(max(cycles(episode), 1u));
                reward += 2.0 * remaining;
            }
        }
        state.last = corner;
    }
    reward -= select(0.0, 0.01, now.collided);
    return Reward(reward, state);
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
    return memory.visited == ALL_CORNERS;
}
