// Eight readings and the two outputs of the cycle before to two outputs in [0, 1]. Genes: for each output
// eight weights, the weights of the previous left and right outputs, and a bias; 22 in all.

const RECURRENT_GENES: u32 = 22u;

fn control(life: Life, readings: Readings, previous: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(
        logistic(weighed(life, 0u, readings) + gene(life, 8u) * previous.x + gene(life, 9u) * previous.y + gene(life, 10u)),
        logistic(weighed(life, 11u, readings) + gene(life, 19u) * previous.x + gene(life, 20u) * previous.y + gene(life, 21u)),
    );
}
