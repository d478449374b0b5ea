// episode-as-given: a function that returns an episode of zeros
fn nobody() -> Life {
    var made: Life;
    return made;
}

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    x = gene(nobody(), 2u);
    return Command(vec2<f32>(x, x), before);
}
