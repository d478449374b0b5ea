// The wheels' commands of a cycle come from outside, in the place of genes.
const CONTROLLER_GENES: u32 = 2u;

fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    return Command(vec2<f32>(gene(life, 0u), gene(life, 1u)), before);
}
