// episode-as-given: a pointer to an episode with a name
const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    var other = episode;
    let p = &other;
    (*p).key = vec2<u32>(1u, 2u);
    x = random(other, STREAM_CONTROLLER, step, 0u).x;
    return Command(vec2<f32>(x, x), before);
}
