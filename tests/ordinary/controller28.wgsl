// Two coupled phase oscillators drive the wheels; readings shift them.

const TAU = 6.283185307179586;
const CONTROLLER_GENES: u32 = 6u + 2u * INPUTS;

struct ControllerState {
    phases: vec2<f32>,
    amplitudes: vec2<f32>,
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let frequency = 0.02 + 0.02 * gene(episode, 0u);
    let coupling = 0.1 * gene(episode, 1u);
    let lag = 0.5 * gene(episode, 2u);
    let offset = vec2<f32>(gene(episode, 3u), gene(episode, 4u));
    let damping = 0.05 + 0.05 * abs(gene(episode, 5u));

    var drive = vec2<f32>(0);
    for (var i = 0u; i < INPUTS; i++) {
        let index = 6u + 2u * i;
        drive += reading(readings, i) * vec2<f32>(gene(episode, index), gene(episode, index + 1u));
    }

    var state = before;
    let gap = state.phases.y - state.phases.x - lag;
    state.phases.x += frequency * (1 + 0.5 * drive.x) + coupling * sin(TAU * gap);
    state.phases.y += frequency * (1 + 0.5 * drive.y) - coupling * sin(TAU * gap);
    state.phases = fract(state.phases);

    let wanted = 1 / (1 + drive * drive);
    state.amplitudes += damping * (wanted - state.amplitudes);

    let wave = state.amplitudes * cos(TAU * state.phases);
    let outputs = 0.5 + 0.5 * tanh(wave + offset + drive);
    return Command(outputs, state);
}
