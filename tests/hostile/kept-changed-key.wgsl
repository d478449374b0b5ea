// episode-as-given: the same, by a field that isn't only the kernel's
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    var other = life;
    other.key.x += 1u;
    x = random(other, STREAM_CONTROLLER, step, 0u).x;
    return Command(vec2<f32>(x, x), before);
}
