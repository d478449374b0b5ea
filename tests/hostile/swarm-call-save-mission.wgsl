// allowed-calls: a function of Oneiro's that writes
fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(life));
    save_mission(64u, before);
    return Tally(x, before);
}
