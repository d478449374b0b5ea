// episode-as-given: an array of episodes that nobody gave
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    var all: array<Episode, 2>;
    x = gene(all[1], 2u);
    return Command(vec2<f32>(x, x), before);
}
