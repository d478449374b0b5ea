// episode-as-given: episodes of all indices
alias L = Episode;

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    for (var i = 0u; i < 9u; i++) { x += gene(L(0u, vec2<u32>(0u, 0u), 64u * i, 0u), 2u); }
    return Command(vec2<f32>(x, x), before);
}
