// episode-as-given: episodes in an array
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    var all = array<Life, 2>(life, life);
    x = gene(all[1], 2u);
    return Command(vec2<f32>(x, x), before);
}
