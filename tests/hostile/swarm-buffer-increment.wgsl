// kernel-buffers: a buffer that is counted up
fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(life));
    state[5]++;
    return Tally(x, before);
}
