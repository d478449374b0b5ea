// gene-count (by its number): more genes than a batch has
const CONTROLLER_GENES: u32 = 4294967295u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    
    return Command(vec2<f32>(x, x), before);
}
