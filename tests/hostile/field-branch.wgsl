// batch-place: a field that decides
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    if life.key.x == 0u { x = 1.0f; }
    return Command(vec2<f32>(x, x), before);
}
