// How outputs command two motors, by the states that were sampled.

// What one pair of motor commands does in one cycle.
struct Motion {
    // mm along the heading
    displacement: f32,
    // turns, counter-clockwise
    turn: f32,
    // signed wheel speeds as a share of the greatest, in [-1, 1]
    left: f32,
    right: f32,
}

// The motor state that an output in [0, 1] selects.
fn motor_state(world: u32, output: f32) -> u32 {
    let scaled = output * worlds[world].motor_scale + worlds[world].motor_offset;
    return min(u32(scaled), worlds[world].motor_states - 1u);
}

// The motion of a pair of motor states, as it was sampled.
struct MotorCell {
    displacement: f32,
    turn: f32,
    left: f32,
    right: f32,
}

// The sampled motion of a pair of outputs (left, right).
fn commanded(world: u32, outputs: vec2<f32>) -> Motion {
    let left = motor_state(world, outputs.x);
    let right = motor_state(world, outputs.y);
    let words = tables[worlds[world].motor_table + left * worlds[world].motor_states + right];
    let cell = MotorCell(bitcast<f32>(words.x), bitcast<f32>(words.y), bitcast<f32>(words.z), bitcast<f32>(words.w));
    return Motion(cell.displacement, cell.turn, cell.left, cell.right);
}

// A cycle's line of the trace. The readings are from the place `seen`.
fn recorded(
    pose: vec3<f32>, seen: vec2<f32>, real: Readings, perceived: Readings,
    outputs: vec2<f32>, moved: Motion, collided: bool, earned: f32, total: f32,
) -> Record {
    return Record(
        pose.x, pose.y, pose.z, seen.x, seen.y,
        perceived.first.x, perceived.first.y, perceived.first.z, perceived.first.w,
        perceived.last.x, perceived.last.y, perceived.last.z, perceived.last.w,
        real.first.x, real.first.y, real.first.z, real.first.w,
        real.last.x, real.last.y, real.last.z, real.last.w,
        outputs.x, outputs.y, moved.left, moved.right,
        select(0.0f, 1.0f, collided), earned, total, 0.0f, 0.0f,
    );
}
