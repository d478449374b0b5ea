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

fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    if (step % CYCLES_PER_ACTION != 0u) {
        return Command(before.outputs, before);
    }
    let first = vec4<f32>(
        hidden(life, 0u, readings, before),
        hidden(life, 1u, readings, before),
        hidden(life, 2u, readings, before),
        hidden(life, 3u, readings, before),
    );
    var now = ControllerState(first, hidden(life, 4u, readings, before), vec2<f32>(0.0f, 0.0f));
    let motors = HIDDEN * UNIT_GENES;
    now.outputs = vec2<f32>(logistic(sum(life, motors, now)), logistic(sum(life, motors + HIDDEN + 1u, now)));
    return Command(now.outputs, now);
}

fn hidden(life: Life, unit: u32, readings: Readings, before: ControllerState) -> f32 {
    let first = unit * UNIT_GENES;
    return logistic(weighed(life, first, readings) + sum(life, first + INPUTS, before));
}

// The hidden units' outputs, each times its gene from gene `first` on, and the gene after them.
fn sum(life: Life, first: u32, own: ControllerState) -> f32 {
    return gene(life, first) * own.first.x + gene(life, first + 1u) * own.first.y + gene(life, first + 2u) * own.first.z
        + gene(life, first + 3u) * own.first.w + gene(life, first + 4u) * own.last + gene(life, first + 5u);
}
