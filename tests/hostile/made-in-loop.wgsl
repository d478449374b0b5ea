// episode-as-given: episodes of all indices
alias L = Life;

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    for (var i = 0u; i < 9u; i++) { x += gene(L(0u, vec2<u32>(0u, 0u), 64u * i), 2u); }
    return Command(vec2<f32>(x, x), before);
}
