// episode-as-given: the number of robots of another world
fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(life));
    var other: Life;
    x = robot_pose(other, 0u).x;
    return Tally(x, before);
}
