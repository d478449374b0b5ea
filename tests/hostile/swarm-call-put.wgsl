// allowed-calls: a function of Oneiro's that writes
fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(life));
    put(64u, 0u, 1.0f);
    return Tally(x, before);
}
