// gene-count (by its number): more genes than a batch has
const CONTROLLER_GENES: u32 = 4294967295u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    
    return Command(vec2<f32>(x, x), before);
}
