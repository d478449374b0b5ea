// gene-count (by its number): no gene, so that none is the last
const CONTROLLER_GENES: u32 = 0u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    
    return Command(vec2<f32>(x, x), before);
}
