// episode-as-given: a mission that moves robots of another world
alias L = Life;

fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(life));
    x = f32(clusters_within(L(0u, vec2<u32>(0u, 0u), 0u, 0u, 0u, 0u), 99.0f).count);
    return Tally(x, before);
}
