// A robot on two wheels whose motors were sampled: for each pair of motor states, how far it goes in one
// cycle and how far it turns.

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

// The sampled motion for a pair of outputs (left, right), with the world's motor noise.
fn motion(life: Life, step: u32, outputs: vec2<f32>) -> Motion {
    let world = life.world;
    let left = motor_state(world, outputs.x);
    let right = motor_state(world, outputs.y);
    let cell = tables[worlds[world].motor_table + left * worlds[world].motor_states + right];
    var moved = Motion(bitcast<f32>(cell.x), bitcast<f32>(cell.y), bitcast<f32>(cell.z), bitcast<f32>(cell.w));
    if (worlds[world].motor_noise > 0.0f) {
        let draw = units(random_words(life.key, STREAM_ACTUATOR, step, 0u));
        moved.displacement *= 1.0f + worlds[world].motor_noise * (2.0f * draw.x - 1.0f);
        moved.turn *= 1.0f + worlds[world].motor_noise * (2.0f * draw.y - 1.0f);
    }
    return moved;
}

// Where a motion leads from a pose (x and y in mm, heading in turns), were nothing in the way.
fn moved_pose(world: u32, pose: vec3<f32>, moved: Motion) -> vec3<f32> {
    let ahead = cosine_sine(pose.z + worlds[world].turn_before_move * moved.turn);
    let heading = pose.z + moved.turn;
    return vec3<f32>(
        pose.x + moved.displacement * ahead.x,
        pose.y + moved.displacement * ahead.y,
        heading - floor(heading),
    );
}

// A free pose, uniform over the world's field and all headings. Of 64 draws none being free leaves the
// world's own free pose, found when the world was made.
fn random_pose(life: Life) -> vec3<f32> {
    let world = life.world;
    var pose = vec3<f32>(worlds[world].start_x, worlds[world].start_y, worlds[world].start_heading);
    for (var draw = 0u; draw < 64u; draw++) {
        let u = units(random_words(life.key, STREAM_START, 0u, draw));
        let at = vec2<f32>(
            worlds[world].field_x + u.x * worlds[world].field_width,
            worlds[world].field_y + u.y * worlds[world].field_height,
        );
        if (!touches(world, at)) {
            pose = vec3<f32>(at, u.z);
            break;
        }
    }
    return pose;
}
