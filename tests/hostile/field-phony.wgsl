// batch-place: a field that is only looked at
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    _ = life.key;
    return Command(vec2<f32>(x, x), before);
}
