// allowed-calls: a function of Oneiro's that takes what it is given
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(episode));
    x = ground_reading(1u, vec2<f32>(0.0f, 0.0f));
    return Tally(x, before);
}
