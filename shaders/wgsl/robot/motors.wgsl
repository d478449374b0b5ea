// How outputs command two motors, by the states that were sampled.

// The motor state that an output in [0, 1] selects.
fn motor_state(world: u32, output: f32) -> u32 {
    let scaled = output * worlds[world].motor_scale + worlds[world].motor_offset;
    return min(u32(scaled), worlds[world].motor_states - 1u);
}

// The sampled motion of a pair of motor states.
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
