// Hebbian plasticity: weights of the first four readings live in memory and change by Oja's rule.
const CONTROLLER_GENES: u32 = 12u;
const USED: u32 = min(INPUTS, 4u);

struct ControllerState {
    to_left: vec4<f32>,
    to_right: vec4<f32>,
}

fn oja(w: vec4<f32>, x: vec4<f32>, y: f32, rate: f32) -> vec4<f32> {
    return w + rate * y * (x - y * w);
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var x = vec4<f32>(0.0);
    for (var i = 0u; i < USED; i++) {
        x[i] = reading(readings, i);
    }
    var weights = before;
    if (step == 0u) {
        for (var i = 0u; i < 4u; i++) {
            weights.to_left[i] = gene(episode, i) * 2.0 - 1.0;
            weights.to_right[i] = gene(episode, 4u + i) * 2.0 - 1.0;
        }
    }
    let y = tanh(vec2<f32>(dot(weights.to_left, x), dot(weights.to_right, x)));
    let rates = 0.1 * vec2<f32>(gene(episode, 8u), gene(episode, 9u));
    let bias = vec2<f32>(gene(episode, 10u), gene(episode, 11u)) - 0.5;
    let new_left = oja(weights.to_left, x, y.x, rates.x);
    let new_right = oja(weights.to_right, x, y.y, rates.y);
    weights.to_left = new_left / max(1.0, length(new_left) / 4.0);
    weights.to_right = new_right / max(1.0, length(new_right) / 4.0);
    return Command(clamp((y + bias) * 0.5 + 0.5, vec2<f32>(0.0), vec2<f32>(1.0)), weights);
}
