// A robot on two wheels whose motors were sampled: for each pair of motor states, how far it goes in one
// cycle and how far it turns.

// What the robot remembers; all zero at the start of an episode.
struct RobotState {
    // 1 once a body that sticks has touched something
    stuck: u32,
}

fn robot_kept(robot: RobotState) -> RobotState {
    return robot;
}

// The sampled motion for a pair of outputs (left, right), with the world's motor noise.
fn motion(episode: Episode, step: u32, outputs: vec2<f32>, before: RobotState) -> Driven {
    return Driven(noisy_motion(episode, step, commanded(episode.world, outputs)), before);
}

// What it remembers after a cycle that ends at a pose.
fn robot_after(world: u32, end: vec3<f32>, robot: RobotState) -> RobotState {
    return robot;
}

// Whether the episode ends.
fn robot_ends(world: u32, robot: RobotState) -> bool {
    return false;
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
