// gene-form: the same, whose comment ends in the part and goes on with declarations
struct ControllerGenes { a: array<f32, 4u / *p> }
/* */ 4u); fn gene(episode: Episode, index: u32) -> f32 { return bitcast<f32>(inputs[index]); }
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    return Command(vec2<f32>(gene(episode, 0u), 0.5f), before);
}
