// SCA: a point for each robot and cycle in the white shelter (Francesca et al. 2015).
fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var inside = 0u;
    for (var robot = 0u; robot < robots(life); robot++) {
        inside += select(0u, 1u, floor_at(life, robot_pose(life, robot).xy) > 0.9f);
    }
    return Tally(f32(inside), before);
}
