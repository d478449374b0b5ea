// Get everywhere: the arena's rectangle is divided into 16 x 16 cells. Fitness: the share of them that the robot's middle has been in,
// 0 to 1, less what collisions cost.

const SIDE: u32 = 16u;

struct TaskValues {
    bump: f32, // 0, 0 to 1000: cost of a cycle that ends in a collision
}

// A bit for each cell.
struct TaskState {
    low: vec4<u32>,
    high: vec4<u32>,
}

fn cell_along(at: f32, low: f32, high: f32) -> u32 {
    return u32(clamp(f32(SIDE) * (at - low) / (high - low), 0.0, f32(SIDE - 1u)));
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let field = arena_field(episode);
    let column = cell_along(now.end.x, field.low.x, field.high.x);
    let row = cell_along(now.end.y, field.low.y, field.high.y);
    let cell = row * SIDE + column;
    let bit = 1u << (cell % 32u);
    let word = cell / 32u;
    var next = before;
    var is_new = false;
    if word < 4u {
        is_new = (before.low[word] & bit) == 0u;
        next.low[word] |= bit;
    } else {
        is_new = (before.high[word - 4u] & bit) == 0u;
        next.high[word - 4u] |= bit;
    }
    var earned = f32(is_new) / f32(SIDE * SIDE);
    if now.collided {
        earned -= task_values(episode).bump;
    }
    return Reward(earned, next);
}
