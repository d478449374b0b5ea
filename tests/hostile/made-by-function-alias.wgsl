// episode-as-given: a function that returns an episode that it makes
alias L = Episode;
fn nobody(genes: u32) -> L { return L(0u, vec2<u32>(0u, genes), genes, 0u); }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    x = gene(nobody(9u), 2u);
    return Command(vec2<f32>(x, x), before);
}
