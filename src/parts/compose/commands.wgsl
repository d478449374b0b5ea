// The motors' commands of a cycle come from outside, as genes. After them is the number of the cycles that the episode has had when this
// one is over, which the entry reads.
const CONTROLLER_GENES: u32 = 3u;

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    return Command(vec2<f32>(gene(episode, 0u), gene(episode, 1u)), before);
}
