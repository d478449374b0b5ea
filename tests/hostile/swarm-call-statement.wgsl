// allowed-calls: a call that is a statement
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(episode));
    put_word(0u, 0u, 1u);
    return Tally(x, before);
}
