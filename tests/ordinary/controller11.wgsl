// Remembers the mean reading of the last eight cycles in a ring buffer and steers by its trend.
const HISTORY: u32 = 8u;
const CONTROLLER_GENES: u32 = 2u * (HISTORY + 1u) + 1u;

struct ControllerState {
    recent: vec4<f32>,
    older: vec4<f32>,
    head: u32,
}

fn mean_reading(readings: Readings) -> f32 {
    var sum: f32 = 0.0;
    for (var i: u32 = 0u; i < INPUTS; i += 1u) {
        sum += reading(readings, i);
    }
    return sum / f32(INPUTS);
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var ring: array<f32, HISTORY>;
    for (var k = 0u; k < 4u; k++) {
        ring[k] = before.recent[k];
        ring[k + 4u] = before.older[k];
    }
    let head = (before.head + 1u) % HISTORY;
    ring[head] = mean_reading(readings);

    var out = vec2<f32>(0.0);
    for (var m = 0u; m < 2u; m++) {
        let first = m * (HISTORY + 1u);
        var sum = gene(episode, first + HISTORY) * 2.0 - 1.0;
        for (var lag = 0u; lag < HISTORY; lag++) {
            let value = ring[(head + HISTORY - lag) % HISTORY];
            sum += (gene(episode, first + lag) * 6.0 - 3.0) * value;
        }
        out[m] = 0.5 + 0.5 * tanh(sum);
    }
    let boost = gene(episode, CONTROLLER_GENES - 1u) * 0.2;
    out = min(out + vec2<f32>(boost), vec2<f32>(1.0));

    var state: ControllerState;
    state.recent = vec4<f32>(ring[0], ring[1], ring[2], ring[3]);
    state.older = vec4<f32>(ring[4], ring[5], ring[6], ring[7]);
    state.head = head;
    return Command(out, state);
}
