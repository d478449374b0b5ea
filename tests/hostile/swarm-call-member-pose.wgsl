// allowed-calls: a function of Oneiro's that takes what it is given
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(episode));
    x = member_pose(64u).x;
    return Tally(x, before);
}
