// AAC: a point for each robot and cycle on the black floor (Francesca et al. 2015).
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var black = 0u;
    for (var robot = 0u; robot < robots(episode); robot++) {
        black += select(0u, 1u, floor_at(episode, robot_pose(episode, robot).xy) < 0.1f);
    }
    return Tally(f32(black), before);
}
