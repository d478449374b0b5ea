// declared-form: a number of genes that is no constant
override CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    
    return Command(vec2<f32>(x, x), before);
}
