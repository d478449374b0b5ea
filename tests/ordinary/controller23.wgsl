// Continuous-time recurrent network, Euler steps.

const NEURONS: u32 = 4u;
const DT: f32 = 0.1;
const SUBSTEPS = 2;
// per neuron: tau, bias, recurrent weights, input weights
const PER_NEURON: u32 = 2u + NEURONS + INPUTS;
const CONTROLLER_GENES: u32 = NEURONS * PER_NEURON;

struct ControllerState {
    potential: vec4<f32>,
}

fn activation(x: vec4<f32>) -> vec4<f32> {
    return 1.0 / (1.0 + exp(-x));
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var y = before.potential;
    var drive = vec4<f32>(0.0);
    var rate = vec4<f32>(0.0);
    var bias = vec4<f32>(0.0);
    var weights: mat4x4<f32>;

    for (var n = 0u; n < NEURONS; n++) {
        let genes = n * PER_NEURON;
        // time constants from 0.1 to 10, spread evenly in the logarithm
        let tau = pow(10.0, clamp(gene(episode, genes), -1.0, 1.0));
        rate[n] = DT / max(tau, 2.0 * DT);
        bias[n] = gene(episode, genes + 1u);
        for (var m = 0u; m < NEURONS; m++) {
            weights[m][n] = 4.0 * gene(episode, genes + 2u + m);
        }
        for (var i = 0u; i < INPUTS; i++) {
            drive[n] += 4.0 * gene(episode, genes + 2u + NEURONS + i) * reading(readings, i);
        }
    }

    for (var k = 0; k < SUBSTEPS; k++) {
        let firing = activation(y + bias);
        y += rate * (-y + weights * firing + drive);
    }
    y = clamp(y, vec4<f32>(-30.0), vec4<f32>(30.0));

    let outputs = activation(y + bias).zw;
    return Command(outputs, ControllerState(y));
}
