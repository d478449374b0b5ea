// allowed-calls: a function of Oneiro's that writes
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(episode));
    put(64u, 0u, 1.0f);
    return Tally(x, before);
}
