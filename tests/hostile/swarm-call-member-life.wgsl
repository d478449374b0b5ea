// allowed-calls: a function of Oneiro's that takes what it is given
fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(life));
    x = robot_pose(member_life(life, 1000u), 0u).x;
    return Tally(x, before);
}
