// episode-as-given: the same, by a field that isn't only the kernel's
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    var other = episode;
    other.key.x += 1u;
    x = random(other, STREAM_CONTROLLER, step, 0u).x;
    return Command(vec2<f32>(x, x), before);
}
