// Gathering: the fitness is the number of robots on the dark floor at the end. docs/swarms.md says what a mission may have.
struct MissionState {
    // robots on the dark floor
    dark: u32,
}

fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var dark = 0u;
    for (var robot = 0u; robot < robots(episode); robot++) {
        dark += select(0u, 1u, floor_at(episode, robot_pose(episode, robot).xy) < 0.1f);
    }
    return Tally(0.0f, MissionState(dark));
}

fn mission_score(episode: Episode, own: MissionState, sum: f32) -> f32 {
    return f32(own.dark);
}
