// A robot on two wheels: the outputs command the wheels' speeds, from full speed backwards to full speed forwards, and a cycle
// is an arc. Its memory and the order of its commands are generated.

const RADIANS_PER_TURN: f32 = 6.2831855f;

// Its first cell of numbers.
struct WheelsCell {
    // mm in a cycle at full speed
    farthest: f32,
    // turns in a cycle for each unit by which the right wheel is faster
    turn: f32,
    // speeds of a wheel less one, and the inverse of that; 0 for any speed
    steps: f32,
    step: f32,
}

fn wheels_of(world: u32) -> WheelsCell {
    let cell = numbers(world, 0u);
    return WheelsCell(cell.x, cell.y, cell.z, cell.w);
}

// A wheel's speed for an output, from -1 to 1, exactly so at both ends.
fn speed_of(wheels: WheelsCell, output: f32) -> f32 {
    if (wheels.steps == 0.0f) {
        return 2.0f * output - 1.0f;
    }
    let level = 2.0f * floor(output * wheels.steps + 0.5f) - wheels.steps;
    let end = select(-1.0f, 1.0f, level > 0.0f);
    return select(level * wheels.step, end, abs(level) == wheels.steps);
}

// The motion of wheels with these speeds (left, right), as fractions of full speed.
fn rolled(wheels: WheelsCell, speeds: vec2<f32>) -> Motion {
    let forward = 0.5f * (speeds.x + speeds.y) * wheels.farthest;
    return Motion(forward, (speeds.y - speeds.x) * wheels.turn, speeds.x, speeds.y);
}

// Where a motion leads from a pose (x and y in mm, heading in turns), were nothing in the way: along an arc, whose chord has
// the direction of half the turn.
fn moved_pose(world: u32, pose: vec3<f32>, moved: Motion) -> vec3<f32> {
    let half = 0.5f * moved.turn;
    let angle = RADIANS_PER_TURN * abs(half);
    var chord = moved.displacement;
    // Below, the chord is as long as the arc in single precision.
    if (angle > 0x1p-12f) {
        chord *= cosine_sine(abs(half)).y * reciprocal(angle);
    }
    let ahead = cosine_sine(pose.z + half);
    let heading = pose.z + moved.turn;
    return vec3<f32>(pose.x + chord * ahead.x, pose.y + chord * ahead.y, heading - floor(heading));
}
