// gene-form: a number of genes whose text ends in a comment when blanks are left out
struct ControllerGenes { a: array<f32, 4u / *p>, b: f32 }
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    return Command(vec2<f32>(gene(episode, A), gene(episode, B)), before);
}
/* */
