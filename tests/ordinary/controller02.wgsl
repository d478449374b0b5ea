// A gated recurrent unit layer with four units.
const UNITS: u32 = 4u;
const ROW: u32 = INPUTS + UNITS + 1u;
const CONTROLLER_GENES: u32 = 3u * UNITS * ROW + 2u * (UNITS + 1u);

struct ControllerState {
    h: vec4<f32>,
}

fn weight(episode: Episode, index: u32) -> f32 {
    return mix(-3.0, 3.0, gene(episode, index));
}

fn logistic(x: vec4<f32>) -> vec4<f32> {
    return 1.0 / (1.0 + exp(-x));
}

fn layer(episode: Episode, readings: Readings, h: vec4<f32>, offset: u32) -> vec4<f32> {
    var out = vec4<f32>(0.0);
    for (var u = 0u; u < UNITS; u++) {
        var index = offset + u * ROW;
        var sum = weight(episode, index);
        index += 1u;
        for (var i = 0u; i < INPUTS; i++) {
            sum += weight(episode, index) * reading(readings, i);
            index += 1u;
        }
        let w = vec4<f32>(weight(episode, index), weight(episode, index + 1u),
                          weight(episode, index + 2u), weight(episode, index + 3u));
        out[u] = sum + dot(w, h);
    }
    return out;
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let z = logistic(layer(episode, readings, before.h, 0u));
    let r = logistic(layer(episode, readings, before.h, UNITS * ROW));
    let candidate = tanh(layer(episode, readings, r * before.h, 2u * UNITS * ROW));
    let h = mix(before.h, candidate, z);

    var motors: vec2<f32>;
    for (var m = 0u; m < 2u; m++) {
        let at = 3u * UNITS * ROW + m * (UNITS + 1u);
        var sum = weight(episode, at);
        for (var u = 0u; u < UNITS; u++) {
            sum += weight(episode, at + 1u + u) * h[u];
        }
        motors[m] = 1.0 / (1.0 + exp(-sum));
    }
    return Command(motors, ControllerState(h));
}
