// Orbit a point counter-clockwise at a given radius.

const PI = 3.14159265359;
const CENTRE = vec2f(500, 500);
const RADIUS = 250.0;
const WIDTH = 60.0;

struct TaskState {
    turned: f32,     // angle swept round the centre, in radians
    best: f32,
}

fn wrap(angle: f32) -> f32 {
    var a = (angle + PI) % (2 * PI);
    if (a < 0) {
        a += 2 * PI;
    }
    return a - PI;
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let a = now.start.xy - CENTRE;
    let b = now.end.xy - CENTRE;
    let swept = wrap(atan2(b.y, b.x) - atan2(a.y, a.x));

    let r = length(b);
    let error = (r - RADIUS) / WIDTH;
    let weight = exp(-0.5 * error * error);

    var state = before;
    state.turned += swept * weight;

    // Only new progress counts, so that going back and forth gains nothing.
    let reward = max(state.turned - state.best, 0) / (2 * PI);
    state.best = max(state.best, state.turned);
    return Reward(reward * 100, state);
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
    return memory.turned > 20 * PI;
}
