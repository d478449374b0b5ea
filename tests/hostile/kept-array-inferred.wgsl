// episode-as-given: the same, without its type
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    x = gene(array(life, life)[1], 2u);
    return Command(vec2<f32>(x, x), before);
}
