// Two LSTM cells that drive the two motors directly.
const CELLS: u32 = 2u;
const GATE_SIZE: u32 = INPUTS + CELLS + 1u;
const CONTROLLER_GENES: u32 = CELLS * 4u * GATE_SIZE;

struct ControllerState {
    hidden: vec2<f32>,
    cell: vec2<f32>,
}

fn sigmoid(x: f32) -> f32 {
    return 1.0 / (1.0 + exp(-x));
}

fn gate(episode: Episode, readings: Readings, hidden: vec2<f32>, which: u32) -> f32 {
    let base = which * GATE_SIZE;
    var sum = 4.0 * gene(episode, base) - 2.0;
    for (var i = 0u; i < INPUTS; i++) {
        sum += (4.0 * gene(episode, base + 1u + i) - 2.0) * reading(readings, i);
    }
    for (var j = 0u; j < CELLS; j++) {
        sum += (4.0 * gene(episode, base + 1u + INPUTS + j) - 2.0) * hidden[j];
    }
    return sum;
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var state = before;
    for (var c = 0u; c < CELLS; c++) {
        let f = sigmoid(gate(episode, readings, before.hidden, c * 4u));
        let i = sigmoid(gate(episode, readings, before.hidden, c * 4u + 1u));
        let o = sigmoid(gate(episode, readings, before.hidden, c * 4u + 2u));
        let g = tanh(gate(episode, readings, before.hidden, c * 4u + 3u));
        state.cell[c] = f * before.cell[c] + i * g;
        state.hidden[c] = o * tanh(state.cell[c]);
    }
    return Command(state.hidden * 0.5 + 0.5, state);
}
