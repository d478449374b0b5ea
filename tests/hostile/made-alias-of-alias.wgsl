// episode-as-given: the same by two names
alias M = L;
alias L = Life;

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    x = gene(M(0u, vec2<u32>(0u, 0u), 0u), 2u);
    return Command(vec2<f32>(x, x), before);
}
