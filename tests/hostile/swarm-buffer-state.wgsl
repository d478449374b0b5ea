// kernel-buffers: the words of another world
fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(life));
    state[0] = 0u;
    return Tally(x, before);
}
