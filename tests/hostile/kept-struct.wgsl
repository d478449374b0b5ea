// episode-as-given: an episode in a struct
struct Pair { who: Episode, x: f32 }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    let pair = Pair(episode, 0.5f);
    x = gene(pair.who, 2u);
    return Command(vec2<f32>(x, x), before);
}
