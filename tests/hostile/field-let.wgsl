// batch-place: a field by another name of the episode
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    let same = life;
    x = f32(same.key.x & 255u);
    return Command(vec2<f32>(x, x), before);
}
