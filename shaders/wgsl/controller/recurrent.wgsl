// The readings and the two outputs of the cycle before to two outputs in [0, 1]. Genes: for each output a weight per reading,
// the weights of the previous left and right outputs, and a bias; 22 in all for eight readings.

const RECURRENT_GENES: u32 = 2u * (INPUTS + 3u);

// The outputs of the cycle before.
struct ControllerState {
    left: f32,
    right: f32,
}

fn controller_begin(episode: Episode) -> ControllerState {
    return ControllerState(0.0f, 0.0f);
}

fn controller_kept(memory: ControllerState) -> ControllerState {
    return ControllerState(stored(memory.left), stored(memory.right));
}

fn commands(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let left = logistic(fed_back(episode, 0u, readings, before));
    let right = logistic(fed_back(episode, INPUTS + 3u, readings, before));
    return Command(vec2<f32>(left, right), ControllerState(left, right));
}

// The input of an output unit whose first gene is `index`.
fn fed_back(episode: Episode, index: u32, readings: Readings, before: ControllerState) -> f32 {
    let previous = index + INPUTS;
    return weighed(episode, index, readings) + gene(episode, previous) * before.left + gene(episode, previous + 1u) * before.right
        + gene(episode, previous + 2u);
}
