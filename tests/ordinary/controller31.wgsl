// Delay line: the summed reading of the last eight cycles in a ring buffer,
// weighed by two evolved filters.

const TAPS = 8u;
const CONTROLLER_GENES: u32 = INPUTS + 2u * TAPS + 2u;

struct ControllerState {
    low: vec4<f32>,
    high: vec4<f32>,
    head: u32,
}

fn store(ring: ptr<function, array<f32, TAPS>>, head: u32, value: f32) -> u32 {
    (*ring)[head] = value;
    return (head + 1u) % TAPS;
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var ring: array<f32, TAPS>;
    for (var i = 0u; i < 4u; i++) {
        ring[i] = before.low[i];
        ring[i + 4u] = before.high[i];
    }

    var signal = 0.0;
    for (var i = 0u; i < INPUTS; i++) {
        signal += gene(episode, i) * reading(readings, i);
    }
    let head = store(&ring, before.head, tanh(signal));

    let left_taps = INPUTS;
    let right_taps = INPUTS + TAPS;
    let bias = INPUTS + 2u * TAPS;
    var motors = vec2<f32>(gene(episode, bias), gene(episode, bias + 1u));
    for (var age = 0u; age < TAPS; age++) {
        let value = ring[(head + TAPS - 1u - age) % TAPS];
        motors.x += value * gene(episode, left_taps + age);
        motors.y += value * gene(episode, right_taps + age);
    }

    let low = vec4<f32>(ring[0], ring[1], ring[2], ring[3]);
    let high = vec4<f32>(ring[4], ring[5], ring[6], ring[7]);
    let outputs = 1.0 / (1.0 + exp(-motors));
    return Command(outputs, ControllerState(low, high, head));
}
