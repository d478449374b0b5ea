// episode-as-given: a function that makes an episode through a pointer
alias L = Episode;
fn change(p: ptr<function, L>) { *p = L(); }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    var other = episode;
    change(&other);
    x = gene(other, 0u);
    return Command(vec2<f32>(x, x), before);
}
