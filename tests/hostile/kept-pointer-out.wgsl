// episode-as-given: a function that makes an episode through a pointer
alias L = Life;
fn change(p: ptr<function, L>) { *p = L(); }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    var other = life;
    change(&other);
    x = gene(other, 0u);
    return Command(vec2<f32>(x, x), before);
}
