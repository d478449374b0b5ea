// Eight readings to `hidden` units to two outputs in [0, 1]. Genes: for each hidden unit eight weights, a
// bias, and its weights to the left and the right output; then the two outputs' biases; 11 hidden + 2 in all.

const HIDDEN_UNIT_GENES: u32 = 11u;
const HIDDEN_OUTPUT_GENES: u32 = 2u;
const GREATEST_HIDDEN: u32 = 32u;

fn control(life: Life, readings: Readings, previous: vec2<f32>) -> vec2<f32> {
    let units_end = HIDDEN_UNIT_GENES * min(worlds[life.world].hidden, GREATEST_HIDDEN);
    var left = gene(life, units_end);
    var right = gene(life, units_end + 1u);
    for (var first = 0u; first < units_end; first += HIDDEN_UNIT_GENES) {
        let output = logistic(weighed(life, first, readings) + gene(life, first + 8u));
        left += gene(life, first + 9u) * output;
        right += gene(life, first + 10u) * output;
    }
    return vec2<f32>(logistic(left), logistic(right));
}
