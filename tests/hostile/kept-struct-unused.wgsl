// episode-as-given: a struct that has an episode, and that nothing uses
struct Pair { who: Episode, x: f32 }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    
    return Command(vec2<f32>(x, x), before);
}
