// Finite state machine with evolved motor settings and thresholds.

const STATES = 4u;
const PER_STATE = 4u; // left, right, threshold, timeout
const CONTROLLER_GENES: u32 = STATES * PER_STATE + INPUTS;

struct ControllerState {
    state: u32,
    timer: i32,
}

fn stimulus(episode: Episode, readings: Readings) -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < INPUTS; i++) {
        sum += gene(episode, STATES * PER_STATE + i) * reading(readings, i);
    }
    return sum / f32(INPUTS);
}

fn next_state(state: u32, fired: bool, expired: bool) -> u32 {
    switch (state) {
        case 0u: {                       // search
            return select(0u, 1u, fired);
        }
        case 1u: {                       // turn
            if (expired) { return 2u; }
            return select(2u, 1u, fired);
        }
        case 2u: {                       // run
            if (fired) { return 3u; }
            return select(2u, 0u, expired);
        }
        case 3u, default: {              // back off
            return select(3u, 1u, expired);
        }
    }
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let genes = before.state * PER_STATE;
    let fired = stimulus(episode, readings) > gene(episode, genes + 2u);
    let timeout = 5 + i32(40.0 * abs(gene(episode, genes + 3u)));
    let state = next_state(before.state, fired, before.timer >= timeout);

    var timer = before.timer + 1;
    if (state != before.state) {
        timer = 0;
    }

    let base = state * PER_STATE;
    let motors = vec2<f32>(gene(episode, base), gene(episode, base + 1u));
    return Command(saturate(0.5 + 0.5 * motors), ControllerState(state, timer));
}
