// reserved-name: a gene that is not limited to its own
fn gene(episode: Episode, index: u32) -> f32 { return 1.0f; }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    
    return Command(vec2<f32>(x, x), before);
}
