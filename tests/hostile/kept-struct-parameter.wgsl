// episode-as-given: a parameter that has an episode in it
struct Pair { who: Episode, x: f32 }
fn second(pair: Pair) -> f32 { return gene(pair.who, 1u); }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    
    return Command(vec2<f32>(x, x), before);
}
