// A small LSTM with four cells.

const UNITS = 4u;
const FAN_IN = INPUTS + UNITS + 1u;
const GATE_GENES = UNITS * FAN_IN;
const CONTROLLER_GENES: u32 = 4u * GATE_GENES + 2u * (UNITS + 1u);

struct ControllerState {
    hidden: vec4<f32>,
    cell: vec4<f32>,
}

fn sigmoid(x: f32) -> f32 {
    return 1.0 / (1.0 + exp(-x));
}

fn gate(episode: Episode, readings: Readings, hidden: vec4<f32>, which: u32, unit: u32) -> f32 {
    var index = which * GATE_GENES + unit * FAN_IN;
    var sum = 0.0;
    for (var i = 0u; i < INPUTS; i++) {
        sum += gene(episode, index) * reading(readings, i);
        index++;
    }
    for (var i = 0u; i < UNITS; i++) {
        sum += gene(episode, index) * hidden[i];
        index++;
    }
    return sum + gene(episode, index);
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var state = before;
    for (var u = 0u; u < UNITS; u++) {
        let input_gate = sigmoid(gate(episode, readings, before.hidden, 0u, u));
        let forget_gate = sigmoid(gate(episode, readings, before.hidden, 1u, u) + 1.0);
        let output_gate = sigmoid(gate(episode, readings, before.hidden, 2u, u));
        let candidate = tanh(gate(episode, readings, before.hidden, 3u, u));
        state.cell[u] = forget_gate * before.cell[u] + input_gate * candidate;
        state.hidden[u] = output_gate * tanh(state.cell[u]);
    }

    var outputs: vec2<f32>;
    for (var o = 0u; o < 2u; o++) {
        let base = 4u * GATE_GENES + o * (UNITS + 1u);
        var sum = gene(episode, base + UNITS);
        for (var u = 0u; u < UNITS; u++) {
            sum += gene(episode, base + u) * state.hidden[u];
        }
        outputs[o] = sigmoid(sum);
    }
    return Command(outputs, state);
}
