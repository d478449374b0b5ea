// A robot on two wheels whose motors were sampled: for each pair of motor states, how far it goes in one
// cycle and how far it turns.

// The sampled motion for a pair of outputs (left, right), with the world's motor noise.
fn motion(life: Life, step: u32, outputs: vec2<f32>) -> Motion {
    return noisy_motion(life, step, commanded(life.world, outputs));
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
