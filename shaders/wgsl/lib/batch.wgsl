// The input buffers that all kernels share. One invocation is one episode: that of a robot, or
// of all robots of a swarm. A workgroup's episodes share what `World` says. A long episode is cut into dispatches of
// `step_begin..step_end`, its state kept between.

// What one dispatch does.
struct Dispatch {
    step_begin: u32,
    step_end: u32,
    // record every Nth step; 0 for no trace
    trace_every: u32,
    // records per episode
    trace_records: u32,
    // where the first group's inputs start in the whole batch
    first_input: u32,
    // the step of the trace's first record
    trace_begin: u32,
    // of kernels with other states and records: their words
    state_words: u32,
    record_words: u32,
}

// Everything that episodes share: robot, arena, noise, controller and task. Lengths in mm.
struct World {
    // cycles of an episode
    steps: u32,
    first_shape: u32,
    shapes: u32,
    // the arena's field
    field_x: f32,
    field_y: f32,
    field_width: f32,
    field_height: f32,
    // the zone that random starts are drawn from: a corner and the sides; or if it is round the middle, the square of the radius
    // around it that is left out, and what the square of the zone's radius has above that
    zone_is_round: u32,
    zone_x: f32,
    zone_y: f32,
    zone_width: f32,
    zone_height: f32,
    // 1 to start each episode at a random free pose, 0 at the pose below
    random_start: u32,
    start_x: f32,
    start_y: f32,
    start_heading: f32,
    // sensor tables: gap of the first row, rows per mm, rows, bearings
    nearest: f32,
    rows_per_mm: f32,
    rows: u32,
    bearings: u32,
    bearings_per_turn: f32,
    // activation of one unit of a reading
    reading_scale: f32,
    sensor_noise_low: f32,
    sensor_noise_span: f32,
    // conservative noise
    walk_range: f32,
    walk_step: f32,
    // motor table: first cell, states of a wheel, and how an output selects one
    motor_table: u32,
    motor_states: u32,
    motor_scale: f32,
    motor_offset: f32,
    motor_noise: f32,
    // fraction of a cycle's turn made before its displacement
    turn_before_move: f32,
    // hidden units, for the controllers that have them
    hidden: u32,
    task_choices: u32,
    // reward for each new cell of the field, and columns of such cells
    new_cell: f32,
    cell_columns: u32,
    // first cell of what only some kernels read: a surrogate robot, or a forager and its arena
    numbers: u32,
    // a collision's effect, in kernels that have a choice: UNDO, KEEP_TURN or SLIDE
    collision: u32,
    // first cell of the values of parts that a user wrote
    own_values: u32,
}

// An object. Of a wall where it starts, where it goes and its direction over its squared length; of others where
// their centre is. The distances to that at which a robot's centre touches it or senses it.
struct Shape {
    x: f32,
    y: f32,
    length_x: f32,
    length_y: f32,
    scaled_x: f32,
    scaled_y: f32,
    contact: f32,
    contact_squared: f32,
    reach_squared: f32,
    // first cell of the sensor table of its class
    table: u32,
    // WALL, ROUND or BLOCK
    kind: u32,
    // 1 for the last object of a layer, within which no two are ever in reach of one robot
    ends_layer: u32,
    // the radius of a round obstacle
    radius: f32,
    // the direction of a wall, or of a block's length
    unit_x: f32,
    unit_y: f32,
    // the fraction of light that it throws back, for the kernels that cast rays
    reflectivity: f32,
    // of a block: half its sides, and from how many points of view it was sampled
    half_length: f32,
    half_width: f32,
    views: u32,
    unused_a: u32,
}

// A workgroup's episodes: their world, how many there are, and where their inputs start.
struct Group {
    world: u32,
    rollouts: u32,
    inputs: u32,
}

@group(0) @binding(0) var<uniform> dispatch: Dispatch;
@group(0) @binding(1) var<storage, read> worlds: array<World>;
@group(0) @binding(2) var<storage, read> shapes: array<Shape>;
// Four words a cell: eight 16-bit readings of sensors, or displacement, turn and wheel speeds of motors.
@group(0) @binding(3) var<storage, read> tables: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> groups: array<Group>;
// A group's inputs, field by field, LANES values a field: the words of the key, then the genes.
@group(0) @binding(5) var<storage, read> inputs: array<u32>;
@group(0) @binding(7) var<storage, read_write> fitness: array<f32>;

const LANES: u32 = 64u;
// Words of the key: the key of its random numbers, and the number of its trial.
const KEY_WORDS: u32 = 3u;

// A number with zero's one sign, as everything is stored.
fn stored(x: f32) -> f32 {
    return select(x, 0.0f, x == 0.0f);
}

// Four numbers of those that only some kernels read.
fn numbers(world: u32, cell: u32) -> vec4<f32> {
    let words = tables[worlds[world].numbers + cell];
    return vec4<f32>(bitcast<f32>(words.x), bitcast<f32>(words.y), bitcast<f32>(words.z), bitcast<f32>(words.w));
}
