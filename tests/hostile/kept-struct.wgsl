// episode-as-given: an episode in a struct
struct Pair { who: Life, x: f32 }

const CONTROLLER_GENES: u32 = 4u;
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = gene(life, 0u);
    let pair = Pair(life, 0.5f);
    x = gene(pair.who, 2u);
    return Command(vec2<f32>(x, x), before);
}
