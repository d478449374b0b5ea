// kernel-buffers: the words of another world
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(episode));
    state[0] = 0u;
    return Tally(x, before);
}
