// episode-as-given: a variable that is only looked at
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    var other = life;
    _ = &other;
    return Command(vec2<f32>(x, x), before);
}
