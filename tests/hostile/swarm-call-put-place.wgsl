// allowed-calls: a function of Oneiro's that writes
fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(life));
    put_place(member_at(life, 0u), 0u, vec2<f32>(9.0f, 9.0f));
    return Tally(x, before);
}
