// Softmax mixture of five fixed behaviours, weighted by a linear score of the readings.
const BEHAVIOURS: u32 = 5u;
const CONTROLLER_GENES: u32 = BEHAVIOURS * (INPUTS + 1u) + 1u;

const ACTIONS = array<vec2<f32>, BEHAVIOURS>(
    vec2<f32>(1.0, 1.0),
    vec2<f32>(0.2, 0.8),
    vec2<f32>(0.8, 0.2),
    vec2<f32>(0.5, 0.5),
    vec2<f32>(0.0, 0.0),
);

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var actions = ACTIONS;
    var scores: array<f32, BEHAVIOURS>;
    var highest = -1e9;
    let temperature = 0.1 + gene(episode, CONTROLLER_GENES - 1u);
    for (var b = 0u; b < BEHAVIOURS; b++) {
        let base = b * (INPUTS + 1u);
        var score = gene(episode, base + INPUTS) - 0.5;
        for (var i = 0u; i < INPUTS; i++) {
            score += (gene(episode, base + i) * 2.0 - 1.0) * reading(readings, i);
        }
        scores[b] = score / temperature;
        highest = max(highest, scores[b]);
    }
    var total = 0.0;
    var blended = vec2<f32>();
    for (var b = 0u; b < BEHAVIOURS; b++) {
        let p = exp(scores[b] - highest);
        blended += p * actions[b];
        total += p;
    }
    return Command(blended / total, before);
}
