// reserved-name: what limits outputs
fn limited(x: f32, low: f32, high: f32) -> f32 { return x; }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    
    return Command(vec2<f32>(x, x), before);
}
