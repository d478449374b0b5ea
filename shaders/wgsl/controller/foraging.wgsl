// The behaviours of O'Dowd, Studley and Winfield (2014) as a forager's controller. It commands ways and turns; its outputs are
// those that would command them.

struct ControllerState {
    escape: f32,
    straight: u32,
    turn: f32,
    wait: u32,
}

fn controller_begin(episode: Episode) -> ControllerState {
    return ControllerState(0.0f, 0u, 0.0f, 0u);
}

fn controller_kept(memory: ControllerState) -> ControllerState {
    return ControllerState(stored(memory.escape), memory.straight, stored(memory.turn), memory.wait);
}

// The commanded way and turn, the outputs, and its memory.
struct Act {
    wanted: Drive,
    outputs: vec2<f32>,
    state: ControllerState,
}

fn act(episode: Episode, step: u32, pose: vec3<f32>, perceived: Readings, before: ControllerState) -> Act {
    let memory = Memory(before.escape, before.straight, before.turn, before.wait);
    let deed = behave(episode, step, pose, perceived.carries > 0.0f, memory);
    let robot = robot_of(episode.world);
    let apart = robot.half_turn_path * deed.wanted.turn;
    let share = 0.5f * reciprocal(robot.farthest);
    let left = 0.5f + share * (deed.wanted.forward - apart);
    let right = 0.5f + share * (deed.wanted.forward + apart);
    let next = deed.memory;
    return Act(
        deed.wanted, vec2<f32>(clamp(left, 0.0f, 1.0f), clamp(right, 0.0f, 1.0f)),
        ControllerState(next.escape, next.straight, next.turn, next.wait),
    );
}
