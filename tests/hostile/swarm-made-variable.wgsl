// episode-as-given: the number of robots of another world
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(episode));
    var other: Episode;
    x = robot_pose(other, 0u).x;
    return Tally(x, before);
}
