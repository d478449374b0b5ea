// The readings to `hidden` units to two outputs in [0, 1]. Genes: for each hidden unit a weight per reading, a bias, and its
// weights to the left and the right output; then the two outputs' biases; 11 hidden + 2 in all for eight readings.

const HIDDEN_UNIT_GENES: u32 = INPUTS + 3u;
const HIDDEN_OUTPUT_GENES: u32 = 2u;
const GREATEST_HIDDEN: u32 = 32u;

fn commands(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let units_end = HIDDEN_UNIT_GENES * min(worlds[episode.world].hidden, GREATEST_HIDDEN);
    var left = gene(episode, units_end);
    var right = gene(episode, units_end + 1u);
    for (var first = 0u; first < units_end; first += HIDDEN_UNIT_GENES) {
        let output = logistic(weighed(episode, first, readings) + gene(episode, first + INPUTS));
        left += gene(episode, first + INPUTS + 1u) * output;
        right += gene(episode, first + INPUTS + 2u) * output;
    }
    return Command(vec2<f32>(logistic(left), logistic(right)), before);
}
