// batch-place: a field that decides
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    if episode.key.x == 0u { x = 1.0f; }
    return Command(vec2<f32>(x, x), before);
}
