// episode-as-given: an episode in an array in a struct in a struct
struct Inner { who: array<Episode, 1> }
struct Outer { inner: array<Inner, 2> }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    var all: Outer;
    x = gene(all.inner[1].who[0], 2u);
    return Command(vec2<f32>(x, x), before);
}
