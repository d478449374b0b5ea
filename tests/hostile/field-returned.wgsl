// batch-place: a field of what a function returns
fn same(life: Life) -> Life { return life; }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    x = f32(same(life).key.y & 255u);
    return Command(vec2<f32>(x, x), before);
}
