// Gathering: the fitness is the number of robots on the dark floor at the end. docs/swarms.md says what a mission may have.
struct MissionState {
    // robots on the dark floor
    dark: u32,
}

fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var dark = 0u;
    for (var robot = 0u; robot < robots(life); robot++) {
        dark += select(0u, 1u, floor_at(life, robot_pose(life, robot).xy) < 0.1f);
    }
    return Tally(0.0f, MissionState(dark));
}

fn mission_score(life: Life, own: MissionState, sum: f32) -> f32 {
    return f32(own.dark);
}
