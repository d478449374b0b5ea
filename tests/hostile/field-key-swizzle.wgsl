// batch-place: the same, both words
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    let both = episode.key.yx;
    x = f32(both.x & 255u);
    return Command(vec2<f32>(x, x), before);
}
