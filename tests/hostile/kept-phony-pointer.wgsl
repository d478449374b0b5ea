// episode-as-given: a variable that is only looked at
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    var other = episode;
    _ = &other;
    return Command(vec2<f32>(x, x), before);
}
