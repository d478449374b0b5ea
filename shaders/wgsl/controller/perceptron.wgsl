// Eight readings to two outputs in [0, 1], one layer. Genes: for each output eight weights and a bias, 18 in all.

const PERCEPTRON_GENES: u32 = 18u;

fn control(life: Life, readings: Readings, previous: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(
        logistic(weighed(life, 0u, readings) + gene(life, 8u)),
        logistic(weighed(life, 9u, readings) + gene(life, 17u)),
    );
}
