// episode-as-given: a parameter that has an episode in it
struct Pair { who: Life, x: f32 }
fn second(pair: Pair) -> f32 { return gene(pair.who, 1u); }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    
    return Command(vec2<f32>(x, x), before);
}
