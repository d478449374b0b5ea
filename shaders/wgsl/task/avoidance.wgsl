// Go fast, go straight, keep away from things: equation 1 of Miglino, Lund and Nolfi (1995),
// F = sum of V (1 - DV^p) (1 - I), with the choices that the paper leaves open as the world's values.

const SIGNED_SPEED: u32 = 1u;
const SQUARED_DIFFERENCE: u32 = 2u;
const PERCEIVED_ACTIVATION: u32 = 4u;
const NO_ACTIVATION_TERM: u32 = 8u;

// The sides of the squares that are counted, mm, and how many of them there are to a mm; and up to how many there are.
const CELL: f32 = 50.0f;
const CELLS_PER_MM: f32 = 0.02f;
const GREATEST_CELLS: u32 = 128u;

// The cell of the field at a place, a bit of four words.
fn cell_at(world: u32, at: vec2<f32>) -> vec4<u32> {
    let column = u32(max((at.x - worlds[world].field_x) * CELLS_PER_MM, 0.0f));
    let row = u32(max((at.y - worlds[world].field_y) * CELLS_PER_MM, 0.0f));
    let cell = row * worlds[world].cell_columns + column;
    let bit = 1u << (cell & 31u);
    return select(vec4<u32>(0u), vec4<u32>(bit), vec4<u32>(cell >> 5u) == vec4<u32>(0u, 1u, 2u, 3u));
}

// The cells of the field that the robot has been in, if they count.
struct TaskState {
    visited: vec4<u32>,
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return TaskState(vec4<u32>(0u));
}

fn task_kept(memory: TaskState) -> TaskState {
    return memory;
}

// In [-1, 1] without new cells. A cycle that ends in a collision earns nothing else: the wheels are stopped.
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let world = episode.world;
    let choices = worlds[world].task_choices;
    let moved = now.moved;
    var speed = 0.5f * (abs(moved.left) + abs(moved.right));
    if ((choices & SIGNED_SPEED) != 0u) {
        speed = 0.5f * (moved.left + moved.right);
    }
    let difference = 0.5f * abs(moved.left - moved.right);
    var turning = difference * difference;
    if ((choices & SQUARED_DIFFERENCE) == 0u) {
        turning = root(difference);
    }
    var near = highest(now.real);
    if ((choices & PERCEIVED_ACTIVATION) != 0u) {
        near = highest(now.perceived);
    }
    if ((choices & NO_ACTIVATION_TERM) != 0u) {
        near = 0.0f;
    }
    var next = Reward(select(speed * (1.0f - turning) * (1.0f - near), 0.0f, now.collided), before);
    if (worlds[world].new_cell > 0.0f) {
        let here = cell_at(world, vec2<f32>(now.end.x, now.end.y));
        let fresh = here & ~before.visited;
        let is_new = ((fresh.x | fresh.y) | (fresh.z | fresh.w)) != 0u;
        next.earned += select(0.0f, worlds[world].new_cell, is_new);
        next.state.visited |= here;
    }
    return next;
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
    return false;
}

fn task_score(episode: Episode, memory: TaskState, sum: f32) -> f32 {
    return sum;
}
