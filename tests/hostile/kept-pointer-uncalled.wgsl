// episode-as-given: a function of a pointer to an episode
fn second(p: ptr<function, Life>) -> f32 { return gene(*p, 1u); }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    
    return Command(vec2<f32>(x, x), before);
}
