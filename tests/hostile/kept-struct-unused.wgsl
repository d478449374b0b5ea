// episode-as-given: a struct that has an episode, and that nothing uses
struct Pair { who: Life, x: f32 }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    
    return Command(vec2<f32>(x, x), before);
}
