// One hidden layer with a Hebbian trace on the readout weights.

const HIDDEN = 4u;
const PER_HIDDEN = INPUTS + 1u;
const READOUT = HIDDEN * PER_HIDDEN;
const PLASTICITY = READOUT + 2u * HIDDEN + 2u;
const CONTROLLER_GENES: u32 = PLASTICITY + 3u;
const DECAY = 0.995;

struct ControllerState {
    left_trace: vec4<f32>,
    right_trace: vec4<f32>,
}

fn hidden_layer(episode: Episode, readings: Readings) -> vec4<f32> {
    var h: vec4<f32>;
    for (var j = 0u; j < HIDDEN; j++) {
        h[j] = gene(episode, j * PER_HIDDEN + INPUTS);
        for (var i = 0u; i < INPUTS; i++) {
            h[j] += gene(episode, j * PER_HIDDEN + i) * reading(readings, i);
        }
    }
    return tanh(h);
}

fn four_genes(episode: Episode, start: u32) -> vec4<f32> {
    return vec4<f32>(
        gene(episode, start), gene(episode, start + 1u),
        gene(episode, start + 2u), gene(episode, start + 3u));
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let h = hidden_layer(episode, readings);
    let left_weights = four_genes(episode, READOUT) + before.left_trace;
    let right_weights = four_genes(episode, READOUT + HIDDEN) + before.right_trace;

    let bias = vec2<f32>(gene(episode, PLASTICITY - 2u), gene(episode, PLASTICITY - 1u));
    let motors = tanh(vec2<f32>(dot(left_weights, h), dot(right_weights, h)) + bias);

    // dw = eta * (A * pre * post + B * pre)
    let eta = 0.01 * gene(episode, PLASTICITY);
    let A = gene(episode, PLASTICITY + 1u);
    let B = gene(episode, PLASTICITY + 2u);
    let limit = vec4<f32>(2.0);
    let left = clamp(before.left_trace * DECAY + eta * h * (A * motors.x + B), -limit, limit);
    let right = clamp(before.right_trace * DECAY + eta * h * (A * motors.y + B), -limit, limit);
    return Command((motors + 1.0) / 2.0, ControllerState(left, right));
}
