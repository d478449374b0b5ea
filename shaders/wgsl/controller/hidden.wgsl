// Eight readings to `hidden` units to two outputs in [0, 1]. Genes: for each hidden unit eight weights, a
// bias, and its weights to the left and the right output; then the two outputs' biases; 11 hidden + 2 in all.

fn control(life: Life, readings: Readings, previous: vec2<f32>) -> vec2<f32> {
    let units_end = 11u * worlds[life.world].hidden;
    var left = gene(life, units_end);
    var right = gene(life, units_end + 1u);
    for (var first = 0u; first < units_end; first += 11u) {
        let output = logistic(weighed(life, first, readings) + gene(life, first + 8u));
        left += gene(life, first + 9u) * output;
        right += gene(life, first + 10u) * output;
    }
    return vec2<f32>(logistic(left), logistic(right));
}
