// kernel-buffers: a buffer that is counted up
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(episode));
    state[5]++;
    return Tally(x, before);
}
