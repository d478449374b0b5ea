// The predator's score: 1 - t / T if it touches the prey after t of T cycles, and 0 if it never does. The prey's is 1 minus that
// (Floreano and Nolfi 1997). The contest ends when they touch.

struct TaskValues {
    gap: f32, // 1, 0.1 to 100 mm: bodies that are as near to each other touch
}

struct MissionState {
    // cycles until they touched, 0 if they have not
    caught: u32,
}

fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    let predator = robot_pose(episode, 0u);
    let prey = robot_pose(episode, 1u);
    let reach = 2.0f * body_radius(episode) + task_values(episode).gap;
    let away = vec2<f32>(prey.x - predator.x, prey.y - predator.y);
    return Tally(0.0f, MissionState(select(0u, step + 1u, squared_length(away) <= reach * reach)));
}

fn mission_ends(episode: Episode, own: MissionState) -> bool {
    return own.caught > 0u;
}

fn mission_score(episode: Episode, own: MissionState, sum: f32) -> f32 {
    let score = 1.0f - f32(own.caught) * reciprocal(f32(cycles(episode)));
    return select(0.0f, score, own.caught > 0u);
}
