// The homing robot's network: all readings and the five hidden units' last outputs to five hidden units, and those to the two
// motors (Floreano and Mondada 1996). It acts in every fourth cycle of 100 ms and holds its commands in between.
//
// Genes: for each hidden unit a weight per reading, the weights of the five hidden units and a bias; then for each motor the
// weights of the five and a bias; 102 with twelve readings.

const HIDDEN: u32 = 5u;
const UNIT_GENES: u32 = INPUTS + HIDDEN + 1u;
const CONTROLLER_GENES: u32 = HIDDEN * UNIT_GENES + 2u * (HIDDEN + 1u);
const CYCLES_PER_ACTION: u32 = 4u;

struct ControllerState {
    // outputs of the hidden units
    first: vec4<f32>,
    last: f32,
    outputs: vec2<f32>,
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    if (step % CYCLES_PER_ACTION != 0u) {
        return Command(before.outputs, before);
    }
    let first = vec4<f32>(
        hidden(episode, 0u, readings, before),
        hidden(episode, 1u, readings, before),
        hidden(episode, 2u, readings, before),
        hidden(episode, 3u, readings, before),
    );
    var now = ControllerState(first, hidden(episode, 4u, readings, before), vec2<f32>(0.0f, 0.0f));
    let motors = HIDDEN * UNIT_GENES;
    now.outputs = vec2<f32>(logistic(sum(episode, motors, now)), logistic(sum(episode, motors + HIDDEN + 1u, now)));
    return Command(now.outputs, now);
}

fn hidden(episode: Episode, unit: u32, readings: Readings, before: ControllerState) -> f32 {
    let first = unit * UNIT_GENES;
    return logistic(weighed(episode, first, readings) + sum(episode, first + INPUTS, before));
}

// The hidden units' outputs, each times its gene from gene `first` on, and the gene after them.
fn sum(episode: Episode, first: u32, own: ControllerState) -> f32 {
    return gene(episode, first) * own.first.x + gene(episode, first + 1u) * own.first.y + gene(episode, first + 2u) * own.first.z
        + gene(episode, first + 3u) * own.first.w + gene(episode, first + 4u) * own.last + gene(episode, first + 5u);
}
