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

// The reward of one cycle, in [-1, 1]. A cycle that ends in a collision earns nothing: the wheels are stopped.
fn reward(world: u32, moved: Motion, collided: bool, real: Readings, perceived: Readings) -> f32 {
    let choices = worlds[world].task_choices;
    var speed = 0.5f * (abs(moved.left) + abs(moved.right));
    if ((choices & SIGNED_SPEED) != 0u) {
        speed = 0.5f * (moved.left + moved.right);
    }
    let difference = 0.5f * abs(moved.left - moved.right);
    var turning = difference * difference;
    if ((choices & SQUARED_DIFFERENCE) == 0u) {
        turning = root(difference);
    }
    var near = highest(real);
    if ((choices & PERCEIVED_ACTIVATION) != 0u) {
        near = highest(perceived);
    }
    if ((choices & NO_ACTIVATION_TERM) != 0u) {
        near = 0.0f;
    }
    return select(speed * (1.0f - turning) * (1.0f - near), 0.0f, collided);
}
