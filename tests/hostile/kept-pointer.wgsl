// episode-as-given: an episode behind a pointer
fn second(p: ptr<function, Life>) -> f32 { return gene(*p, 1u); }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    var other = life;
    x = second(&other);
    return Command(vec2<f32>(x, x), before);
}
