// allowed-calls: a function of Oneiro's that writes
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(episode));
    save_mission(64u, before);
    return Tally(x, before);
}
