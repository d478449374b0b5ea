// The wheels' commands of a cycle come from outside, as genes.
const CONTROLLER_GENES: u32 = 2u;

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    return Command(vec2<f32>(gene(episode, 0u), gene(episode, 1u)), before);
}
