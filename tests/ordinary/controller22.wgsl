// Gated recurrent unit with six hidden units.

const HIDDEN = 6u;
const ROW = INPUTS + HIDDEN + 1u;
const READOUT = 3u * HIDDEN * ROW;
const CONTROLLER_GENES: u32 = READOUT + 2u * (HIDDEN + 1u);

struct ControllerState {
    a: vec3<f32>,
    b: vec3<f32>,
}

fn logistic(x: f32) -> f32 {
    return 1.0 / (1.0 + exp(-clamp(x, -20.0, 20.0)));
}

fn row(episode: Episode, readings: Readings, h: array<f32, HIDDEN>, block: u32, unit: u32) -> f32 {
    let start = (block * HIDDEN + unit) * ROW;
    var values = h;
    var sum = gene(episode, start + ROW - 1u);
    for (var i = 0u; i < INPUTS; i++) {
        sum += gene(episode, start + i) * (2.0 * reading(readings, i) - 1.0);
    }
    for (var i = 0u; i < HIDDEN; i++) {
        sum += gene(episode, start + INPUTS + i) * values[i];
    }
    return sum;
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var h = array<f32, HIDDEN>(before.a.x, before.a.y, before.a.z, before.b.x, before.b.y, before.b.z);
    var update: array<f32, HIDDEN>;
    var gated: array<f32, HIDDEN>;

    for (var j = 0u; j < HIDDEN; j++) {
        update[j] = logistic(row(episode, readings, h, 0u, j));
        gated[j] = logistic(row(episode, readings, h, 1u, j)) * h[j];
    }
    for (var j = 0u; j < HIDDEN; j++) {
        let candidate = tanh(row(episode, readings, gated, 2u, j));
        h[j] = mix(h[j], candidate, update[j]);
    }

    var motors = vec2<f32>(gene(episode, READOUT), gene(episode, READOUT + 1u));
    for (var j = 0u; j < HIDDEN; j++) {
        let at = READOUT + 2u + 2u * j;
        motors += h[j] * vec2<f32>(gene(episode, at), gene(episode, at + 1u));
    }
    let outputs = vec2<f32>(logistic(motors.x), logistic(motors.y));
    return Command(outputs, ControllerState(vec3(h[0], h[1], h[2]), vec3(h[3], h[4], h[5])));
}
