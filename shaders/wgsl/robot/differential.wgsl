// A robot on two wheels whose motors were sampled: for each pair of motor states, how far it goes in one
// cycle and how far it turns.

// The sampled motion for a pair of outputs (left, right), with the world's motor noise.
fn motion(life: Life, step: u32, outputs: vec2<f32>) -> Motion {
    let world = life.world;
    var moved = commanded(world, outputs);
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
