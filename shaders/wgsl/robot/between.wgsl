// Sampled motors whose wheels' speeds change gradually: the motion of speeds between those that were sampled. Speeds are fractions of
// full speed; states have ascending ones.

// The speed of a motor state.
fn speed_of_state(world: u32, state: u32) -> f32 {
    return bitcast<f32>(tables[worlds[world].motor_table + state * (worlds[world].motor_states + 1u)].z);
}

// The speeds of the states that a pair of outputs selects (left, right).
fn commanded_speeds(world: u32, outputs: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(
        speed_of_state(world, motor_state(world, outputs.x)), speed_of_state(world, motor_state(world, outputs.y)),
    );
}

// The state below a speed, and how far the speed is on its way to the next, 0 to 1.
struct BetweenStates {
    state: u32,
    share: f32,
}

fn between_states(world: u32, speed: f32) -> BetweenStates {
    var low = 0u;
    var high = worlds[world].motor_states - 1u;
    // 2^8 states at most.
    for (var turn = 0u; turn < 8u; turn++) {
        let middle = (low + high) / 2u;
        if (high - low > 1u) {
            if (speed_of_state(world, middle) <= speed) {
                low = middle;
            } else {
                high = middle;
            }
        }
    }
    let below = speed_of_state(world, low);
    let above = speed_of_state(world, high);
    let share = clamp((speed - below) * reciprocal(above - below), 0.0f, 1.0f);
    return BetweenStates(low, select(share, 1.0f, speed >= above));
}

// Displacement and turn of a pair of states.
fn sampled_motion(world: u32, left: u32, right: u32) -> vec2<f32> {
    let words = tables[worlds[world].motor_table + left * worlds[world].motor_states + right];
    return vec2<f32>(bitcast<f32>(words.x), bitcast<f32>(words.y));
}

// The motion of a pair of speeds (left, right): that of the four pairs of states around it, each by how near it is. Exactly that of
// a pair of states at their speeds.
fn motion_between(world: u32, speeds: vec2<f32>) -> Motion {
    let left = between_states(world, speeds.x);
    let right = between_states(world, speeds.y);
    let slower = sampled_motion(world, left.state, right.state) * (1.0f - right.share)
        + sampled_motion(world, left.state, right.state + 1u) * right.share;
    let faster = sampled_motion(world, left.state + 1u, right.state) * (1.0f - right.share)
        + sampled_motion(world, left.state + 1u, right.state + 1u) * right.share;
    let moved = slower * (1.0f - left.share) + faster * left.share;
    return Motion(moved.x, moved.y, speeds.x, speeds.y);
}
