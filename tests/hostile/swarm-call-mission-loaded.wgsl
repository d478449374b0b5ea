// allowed-calls: a function of Oneiro's that takes what it is given
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(episode));
    x = f32(clusters_within(episode, 9.0f).count) + score(episode);
    return Tally(x, before);
}
