// batch-place: a field of an episode in brackets
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    x = f32((life).genes);
    return Command(vec2<f32>(x, x), before);
}
