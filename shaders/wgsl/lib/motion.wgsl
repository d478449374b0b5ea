// A robot's motion in one cycle, motor noise, and the record of the cycle.

// The effect of a pair of motor commands over one cycle.
struct Motion {
    // mm along the heading
    displacement: f32,
    // turns, counter-clockwise
    turn: f32,
    // signed wheel speeds as a fraction of the maximum, in [-1, 1]
    left: f32,
    right: f32,
}

// A motion with the world's motor noise.
fn noisy_motion(episode: Episode, step: u32, commanded: Motion) -> Motion {
    let world = episode.world;
    var moved = commanded;
    if (worlds[world].motor_noise > 0.0f) {
        let draw = units(random_words(episode.key, STREAM_ACTUATOR, step, 0u));
        moved.displacement *= 1.0f + worlds[world].motor_noise * (2.0f * draw.x - 1.0f);
        moved.turn *= 1.0f + worlds[world].motor_noise * (2.0f * draw.y - 1.0f);
    }
    return moved;
}

// The record of a cycle. `seen` is the position that the readings were taken from.
fn recorded(
    pose: vec3<f32>, seen: vec2<f32>, outputs: vec2<f32>, moved: Motion, collided: bool, earned: f32, total: f32,
) -> Record {
    return Record(
        pose.x, pose.y, pose.z, seen.x, seen.y,
        outputs.x, outputs.y, moved.left, moved.right,
        select(0.0f, 1.0f, collided), earned, total,
    );
}
