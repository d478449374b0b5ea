// reserved-name: what stands between the kernel and the controller
fn commands(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command { return Command(vec2<f32>(9.0f, 9.0f), before); }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    
    return Command(vec2<f32>(x, x), before);
}
