// batch-place: a field that is only looked at
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    _ = episode.key;
    return Command(vec2<f32>(x, x), before);
}
