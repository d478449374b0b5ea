// batch-place: a field on another line
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    x = f32(episode
        .
        genes);
    return Command(vec2<f32>(x, x), before);
}
