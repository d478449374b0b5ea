// The readings to `hidden` units to two outputs in [0, 1]. Genes: for each hidden unit a weight per reading, a bias, and its
// weights to the left and the right output; then the two outputs' biases; 11 hidden + 2 in all for eight readings.

const HIDDEN_UNIT_GENES: u32 = INPUTS + 3u;
const HIDDEN_OUTPUT_GENES: u32 = 2u;
const GREATEST_HIDDEN: u32 = 32u;

fn commands(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    let units_end = HIDDEN_UNIT_GENES * min(worlds[life.world].hidden, GREATEST_HIDDEN);
    var left = gene(life, units_end);
    var right = gene(life, units_end + 1u);
    for (var first = 0u; first < units_end; first += HIDDEN_UNIT_GENES) {
        let output = logistic(weighed(life, first, readings) + gene(life, first + INPUTS));
        left += gene(life, first + INPUTS + 1u) * output;
        right += gene(life, first + INPUTS + 2u) * output;
    }
    return Command(vec2<f32>(logistic(left), logistic(right)), before);
}
