// episode-as-given: a mission that moves robots of another world
alias L = Episode;

fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(episode));
    x = f32(clusters_within(L(0u, vec2<u32>(0u, 0u), 0u, 0u, 0u, 0u, 0u), 99.0f).count);
    return Tally(x, before);
}
