// The readings to two outputs in [0, 1], one layer. Genes: for each output a weight per reading and a bias, 18 in all for
// eight readings.

const PERCEPTRON_GENES: u32 = 2u * (INPUTS + 1u);

fn commands(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let outputs = vec2<f32>(
        logistic(weighed(episode, 0u, readings) + gene(episode, INPUTS)),
        logistic(weighed(episode, INPUTS + 1u, readings) + gene(episode, 2u * INPUTS + 1u)),
    );
    return Command(outputs, before);
}
