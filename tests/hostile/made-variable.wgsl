// episode-as-given: reads another's genes by an episode that is all zero
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    var nobody: Episode;
    x = gene(nobody, 2u);
    return Command(vec2<f32>(x, x), before);
}
