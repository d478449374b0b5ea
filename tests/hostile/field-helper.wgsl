// batch-place: a field in another function
fn place(who: Episode) -> f32 { return f32(who.key.x & 255u); }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    x = place(episode);
    return Command(vec2<f32>(x, x), before);
}
