// own-buffers: an episode in a global variable
var<private> held: Life;

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    x = gene(held, 2u);
    held = life;
    return Command(vec2<f32>(x, x), before);
}
