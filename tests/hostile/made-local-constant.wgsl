// episode-as-given: an episode that is a constant of the function
alias L = Episode;

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    const nobody = L();
    x = gene(nobody, 2u);
    return Command(vec2<f32>(x, x), before);
}
