// allowed-calls: a function of Oneiro's that writes
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(episode));
    put_place(member_at(episode, 0u), 0u, vec2<f32>(9.0f, 9.0f));
    return Tally(x, before);
}
