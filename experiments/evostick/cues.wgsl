// AAC: a point for each robot and cycle on the black floor (Francesca et al. 2015).
fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var black = 0u;
    for (var robot = 0u; robot < robots(life); robot++) {
        black += select(0u, 1u, floor_at(life, robot_pose(life, robot).xy) < 0.1f);
    }
    return Tally(f32(black), before);
}
