// valid-wgsl: genes whose number overflows
struct ControllerGenes { a: array<f32, 1073741823>, b: array<f32, 1073741823>, c: array<f32, 1073741823>, d: array<f32, 1073741823>, e: array<f32, 9> }
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    return Command(vec2<f32>(gene(episode, A), gene(episode, E)), before);
}
