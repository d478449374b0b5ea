// PID to a heading. Reading 0 is taken as a compass in turns, the others
// push the wanted heading away from obstacles.

const CONTROLLER_GENES: u32 = 5u + INPUTS;
const WINDUP: f32 = 2.0;

struct ControllerState {
    integral: f32,
    error: f32,
    started: u32,
}

fn heading_error(wanted: f32, actual: f32) -> f32 {
    let d = wanted - actual;
    return d - floor(d + 0.5);
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let kp = 4.0 * abs(gene(episode, 0u));
    let ki = 0.2 * abs(gene(episode, 1u));
    let kd = 2.0 * abs(gene(episode, 2u));
    let cruise = gene(episode, 3u);

    var wanted = gene(episode, 4u);
    for (var i = 1u; i < INPUTS; i++) {
        wanted += 0.25 * gene(episode, 5u + i) * reading(readings, i);
    }

    let error = heading_error(wanted, reading(readings, 0u));
    var state = before;
    state.integral = clamp(state.integral * 0.99 + error, -WINDUP, WINDUP);
    let derivative = select(0.0, error - state.error, state.started == 1u);
    state.error = error;
    state.started = 1u;

    let turn = kp * error + ki * state.integral + kd * derivative;
    // Slow down in tight turns.
    let speed = cruise / (1.0 + turn * turn);
    let left = clamp(0.5 * (speed - turn) + 0.5, 0.0, 1.0);
    let right = clamp(0.5 * (speed + turn) + 0.5, 0.0, 1.0);
    return Command(vec2<f32>(left, right), state);
}
