// One robot's life: sense, act, move, reward, cycle by cycle. One invocation is one rollout; a workgroup's
// rollouts share a world. A long life is cut into dispatches of `step_begin..step_end`, its state kept between.

// What one dispatch does.
struct Dispatch {
    step_begin: u32,
    step_end: u32,
    // a record each so many steps; 0 for no trace
    trace_every: u32,
    // records a rollout
    trace_records: u32,
    // where the first group's inputs start in the whole batch
    first_input: u32,
    unused_a: u32,
    unused_b: u32,
    unused_c: u32,
}

// Everything that rollouts share: robot, arena, noise, controller and task. Lengths in mm.
struct World {
    // cycles of a life
    steps: u32,
    first_shape: u32,
    shapes: u32,
    // the field that random starts are drawn from
    field_x: f32,
    field_y: f32,
    field_width: f32,
    field_height: f32,
    // 1 to start each life at a random free pose, 0 at the pose below
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
    // share of a cycle's turn that is made before its displacement
    turn_before_move: f32,
    // hidden units, for the controllers that have them
    hidden: u32,
    task_choices: u32,
    unused_a: u32,
    unused_b: u32,
    unused_c: u32,
}

// A thick segment: where it starts, where it goes, its direction over its squared length, and the distances
// from its axis at which a robot's centre touches it or senses it.
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
    // 1 for an object without length
    round: u32,
    // 1 for the last object of a layer, within which no two are ever in reach of one robot
    ends_layer: u32,
}

// A workgroup's rollouts: their world, how many there are, and where their inputs start.
struct Group {
    world: u32,
    rollouts: u32,
    inputs: u32,
}

// What a rollout keeps from one dispatch to the next, and its fitness so far.
struct State {
    x: f32,
    y: f32,
    heading: f32,
    fitness: f32,
    shift_x: f32,
    shift_y: f32,
    left: f32,
    right: f32,
}

// One line of a trace: the pose at the start of a cycle, what was perceived there, and what came of it.
struct Record {
    x: f32,
    y: f32,
    heading: f32,
    sensor_0: f32,
    sensor_1: f32,
    sensor_2: f32,
    sensor_3: f32,
    sensor_4: f32,
    sensor_5: f32,
    sensor_6: f32,
    sensor_7: f32,
    left: f32,
    right: f32,
    speed_left: f32,
    speed_right: f32,
    collided: f32,
    reward: f32,
    fitness: f32,
}

@group(0) @binding(0) var<uniform> dispatch: Dispatch;
@group(0) @binding(1) var<storage, read> worlds: array<World>;
@group(0) @binding(2) var<storage, read> shapes: array<Shape>;
// Four words a cell: eight 16-bit readings of sensors, or displacement, turn and wheel speeds of motors.
@group(0) @binding(3) var<storage, read> tables: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> groups: array<Group>;
// A group's inputs, field by field, LANES values a field: the two words of the key, then the genes.
@group(0) @binding(5) var<storage, read> inputs: array<u32>;
@group(0) @binding(6) var<storage, read_write> state: array<State>;
@group(0) @binding(7) var<storage, read_write> fitness: array<f32>;
@group(0) @binding(8) var<storage, read_write> trace: array<Record>;

const LANES: u32 = 64u;

// Who lives: the world, the key of its random numbers, and the index of its first gene.
struct Life {
    world: u32,
    key: vec2<u32>,
    genes: u32,
}

fn gene(life: Life, index: u32) -> f32 {
    return bitcast<f32>(inputs[life.genes + index * LANES]);
}

// A number with zero's one sign, as everything is stored.
fn stored(x: f32) -> f32 {
    return select(x, 0.0f, x == 0.0f);
}

fn first_state(life: Life) -> State {
    var pose = vec3<f32>(worlds[life.world].start_x, worlds[life.world].start_y, worlds[life.world].start_heading);
    if (worlds[life.world].random_start != 0u) {
        pose = random_pose(life);
    }
    let shift = first_shift(life);
    return State(pose.x, pose.y, pose.z, 0.0f, shift.x, shift.y, 0.0f, 0.0f);
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let group = workgroup.x;
    if (lane >= groups[group].rollouts) {
        return;
    }
    let slot = group * LANES + lane;
    let input = groups[group].inputs - dispatch.first_input + lane;
    let world = groups[group].world;
    let life = Life(world, vec2<u32>(inputs[input], inputs[input + LANES]), input + 2u * LANES);

    var own: State;
    if (dispatch.step_begin == 0u) {
        own = first_state(life);
    } else {
        own = state[slot];
    }

    let end = min(dispatch.step_end, worlds[world].steps);
    for (var step = dispatch.step_begin; step < end; step++) {
        let pose = vec3<f32>(own.x, own.y, own.heading);
        var shift = vec2<f32>(0.0f, 0.0f);
        if (worlds[world].walk_range > 0.0f) {
            shift = vec2<f32>(own.shift_x, own.shift_y);
            let next = walked(life, step, shift);
            own.shift_x = next.x;
            own.shift_y = next.y;
        }
        let real = sense(world, pose, shift);
        let perceived = with_noise(life, step, real);
        let outputs = control(life, perceived, vec2<f32>(own.left, own.right));
        let moved = motion(life, step, outputs);
        let reached = moved_pose(world, pose, moved);
        let collided = touches(world, vec2<f32>(reached.x, reached.y));
        let earned = reward(world, moved, collided, real, perceived);

        // A collision undoes the move.
        own.x = select(reached.x, pose.x, collided);
        own.y = select(reached.y, pose.y, collided);
        own.heading = select(reached.z, pose.z, collided);
        own.fitness += earned;
        own.left = outputs.x;
        own.right = outputs.y;

        if (dispatch.trace_every > 0u && step % dispatch.trace_every == 0u) {
            trace[slot * dispatch.trace_records + step / dispatch.trace_every] = Record(
                stored(pose.x), stored(pose.y), stored(pose.z),
                stored(perceived.first.x), stored(perceived.first.y), stored(perceived.first.z), stored(perceived.first.w),
                stored(perceived.last.x), stored(perceived.last.y), stored(perceived.last.z), stored(perceived.last.w),
                stored(outputs.x), stored(outputs.y), stored(moved.left), stored(moved.right),
                select(0.0f, 1.0f, collided), stored(earned), stored(own.fitness),
            );
        }
    }

    state[slot] = State(
        stored(own.x), stored(own.y), stored(own.heading), stored(own.fitness),
        stored(own.shift_x), stored(own.shift_y), stored(own.left), stored(own.right),
    );
    fitness[slot] = stored(own.fitness);
}
