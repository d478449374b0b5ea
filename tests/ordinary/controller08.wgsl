// Central pattern generator: two coupled Hopf oscillators, readings change the frequency.
const CONTROLLER_GENES: u32 = INPUTS + 5u;
const TAU: f32 = 6.283185307;
const DT: f32 = 0.05;

struct ControllerState {
    left: vec2<f32>,
    right: vec2<f32>,
    started: u32,
}

fn rotate(v: vec2<f32>, angle: f32) -> vec2<f32> {
    let c = cos(angle);
    let s = sin(angle);
    return mat2x2<f32>(c, s, -s, c) * v;
}

fn hopf(v: vec2<f32>, omega: f32, coupling: vec2<f32>) -> vec2<f32> {
    let r2 = dot(v, v);
    let grow = 8.0 * (1.0 - r2);
    return vec2<f32>(grow * v.x - omega * v.y, grow * v.y + omega * v.x) + coupling;
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var state = before;
    if (!bool(state.started)) {
        state.left = vec2<f32>(1.0, 0.0);
        state.right = rotate(state.left, TAU * gene(episode, 0u));
        state.started = 1u;
    }
    var excitement = 0.0;
    for (var i = 0u; i < INPUTS; i++) {
        excitement += (gene(episode, 5u + i) * 2.0 - 1.0) * reading(readings, i);
    }
    let omega = TAU * mix(0.2, 2.0, gene(episode, 1u)) * exp2(tanh(excitement));
    let lag = TAU * (gene(episode, 2u) - 0.5);
    let k = 3.0 * gene(episode, 3u);
    let dl = hopf(state.left, omega, k * (rotate(state.right, lag) - state.left));
    let dr = hopf(state.right, omega, k * (rotate(state.left, -lag) - state.right));
    state.left += dl * DT;
    state.right += dr * DT;
    state.left = clamp(state.left, vec2<f32>(-2.0), vec2<f32>(2.0));
    state.right = clamp(state.right, vec2<f32>(-2.0), vec2<f32>(2.0));
    let amplitude = 0.5 * gene(episode, 4u);
    let outputs = saturate(0.6 + amplitude * vec2<f32>(state.left.x, state.right.x));
    return Command(outputs, state);
}
