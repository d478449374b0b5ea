// own-buffers: an episode in a global variable
var<private> held: Episode;

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    x = gene(held, 2u);
    held = episode;
    return Command(vec2<f32>(x, x), before);
}
