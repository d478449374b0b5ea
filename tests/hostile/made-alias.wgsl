// episode-as-given: an episode that is made by another name of its type
alias L = Episode;

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    x = gene(L(0u, vec2<u32>(0u, 0u), 0u, 0u), 2u);
    return Command(vec2<f32>(x, x), before);
}
