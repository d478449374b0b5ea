// batch-place: a field by another name of the episode
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    let same = episode;
    x = f32(same.key.x & 255u);
    return Command(vec2<f32>(x, x), before);
}
