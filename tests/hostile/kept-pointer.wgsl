// episode-as-given: an episode behind a pointer
fn second(p: ptr<function, Episode>) -> f32 { return gene(*p, 1u); }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    var other = episode;
    x = second(&other);
    return Command(vec2<f32>(x, x), before);
}
