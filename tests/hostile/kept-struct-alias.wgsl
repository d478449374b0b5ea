// episode-as-given: an episode in a struct, by another name
alias L = Episode;
struct Pair { who: L }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    x = gene(Pair().who, 2u);
    return Command(vec2<f32>(x, x), before);
}
