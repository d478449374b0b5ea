// episode-as-given: the same, with its type
alias L = Episode;
const NOBODY: Episode = L();

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    x = gene(NOBODY, 2u);
    return Command(vec2<f32>(x, x), before);
}
