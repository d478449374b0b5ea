// episode-as-given: an episode that is stored
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    var other = life;
    other = life;
    x = gene(other, 2u);
    return Command(vec2<f32>(x, x), before);
}
