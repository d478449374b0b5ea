// allowed-calls: what stands between the kernel and the controller
fn again(episode: Episode, step: u32, r: Readings, c: ControllerState) -> f32 { return commands(episode, step, r, c).outputs.x; }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    
    return Command(vec2<f32>(x, x), before);
}
