// Two-layer perceptron with tanh, five hidden units.
const HIDDEN: u32 = 5u;
const OUTPUTS: u32 = 2u;
const GENES_1: u32 = HIDDEN * (INPUTS + 1u);
const GENES_2: u32 = OUTPUTS * (HIDDEN + 1u);
const CONTROLLER_GENES: u32 = GENES_1 + GENES_2;
const RANGE: f32 = 4.0;

fn synapse(episode: Episode, index: u32) -> f32 {
    return (gene(episode, index) - 0.5) * 2.0 * RANGE;
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var hidden = array<f32, HIDDEN>();
    var genes: u32 = 0u;
    for (var h = 0u; h < HIDDEN; h++) {
        var activation = synapse(episode, genes);
        genes++;
        for (var i = 0u; i < INPUTS; i++) {
            activation += synapse(episode, genes) * (reading(readings, i) * 2.0 - 1.0);
            genes++;
        }
        hidden[h] = tanh(activation);
    }
    var outputs = vec2<f32>(0.0, 0.0);
    for (var o = 0u; o < OUTPUTS; o++) {
        var activation = synapse(episode, genes);
        genes++;
        for (var h = 0u; h < HIDDEN; h++) {
            activation += synapse(episode, genes) * hidden[h];
            genes++;
        }
        outputs[o] = 0.5 + tanh(activation) / 2.0;
    }
    return Command(outputs, before);
}
