// episode-as-given: an array of episodes that nobody gave
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    var all: array<Life, 2>;
    x = gene(all[1], 2u);
    return Command(vec2<f32>(x, x), before);
}
