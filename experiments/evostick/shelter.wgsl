// SCA: a point for each robot and cycle in the white shelter (Francesca et al. 2015).
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var inside = 0u;
    for (var robot = 0u; robot < robots(episode); robot++) {
        inside += select(0u, 1u, floor_at(episode, robot_pose(episode, robot).xy) > 0.9f);
    }
    return Tally(f32(inside), before);
}
