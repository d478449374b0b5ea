// allowed-calls: a function of Oneiro's that takes what it is given
fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(life));
    x = f32(member_at(life, 1000u));
    return Tally(x, before);
}
