// episode-as-given: the same, by another name
alias P = ptr<function, Episode>;
fn second(p: P) -> f32 { return gene(*p, 1u); }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(episode, 0u);
    
    return Command(vec2<f32>(x, x), before);
}
