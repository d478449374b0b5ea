// What a forager wants to drive where its controller gives two outputs: 0 commands a wheel's full speed backwards, 1 forwards.

// The commanded way and turn, the controller's outputs, and its memory.
struct Act {
    wanted: Drive,
    outputs: vec2<f32>,
    state: ControllerState,
}

fn act(episode: Episode, step: u32, pose: vec3<f32>, perceived: Readings, before: ControllerState) -> Act {
    let command = commands(episode, step, perceived, before);
    let robot = robot_of(episode.world);
    let left = robot.farthest * (2.0f * command.outputs.x - 1.0f);
    let right = robot.farthest * (2.0f * command.outputs.y - 1.0f);
    let wanted = Drive(0.5f * (left + right), (right - left) * reciprocal(2.0f * robot.half_turn_path));
    return Act(wanted, command.outputs, command.state);
}
