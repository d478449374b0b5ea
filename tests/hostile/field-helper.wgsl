// batch-place: a field in another function
fn place(who: Life) -> f32 { return f32(who.key.x & 255u); }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    x = place(life);
    return Command(vec2<f32>(x, x), before);
}
