// episode-as-given: episodes in an array
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    var all = array<Episode, 2>(episode, episode);
    x = gene(all[1], 2u);
    return Command(vec2<f32>(x, x), before);
}
