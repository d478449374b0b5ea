// An e-puck on two wheels that slip a little: what it drives in one cycle.

// The commanded way and turn of a cycle.
struct Drive {
    // mm along the mean heading
    forward: f32,
    // turns, counter-clockwise
    turn: f32,
}

// Its motion: each wheel has its maximum speed, and goes a random fraction more or less.
fn driven(episode: Episode, step: u32, wanted: Drive) -> Drive {
    let robot = robot_of(episode.world);
    let apart = robot.half_turn_path * wanted.turn;
    let noise = 2.0f * units(random_words(episode.key, STREAM_ACTUATOR, step, 0u)) - 1.0f;
    let gains = wheels(episode);
    let left = gains.x * (clamp(wanted.forward - apart, -robot.farthest, robot.farthest) * (1.0f + robot.wheel_noise * noise.x));
    let right = gains.y * (clamp(wanted.forward + apart, -robot.farthest, robot.farthest) * (1.0f + robot.wheel_noise * noise.y));
    return Drive(0.5f * (left + right), (right - left) * reciprocal(2.0f * robot.half_turn_path));
}

// Where that leads from a pose (x and y in mm, heading in turns), along the heading that it has half way.
fn driven_pose(pose: vec3<f32>, moved: Drive) -> vec3<f32> {
    let ahead = cosine_sine(pose.z + 0.5f * moved.turn);
    let heading = pose.z + moved.turn;
    return vec3<f32>(pose.x + moved.forward * ahead.x, pose.y + moved.forward * ahead.y, heading - floor(heading));
}
