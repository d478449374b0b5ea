// Homing: go out far in the first half, come back home by the end.

const FAR = 600.0;

struct TaskState {
    home: vec2<f32>,
    home_heading: f32,
    excursion: f32,
}

fn turn_difference(a: f32, b: f32) -> f32 {
    let d = a - b;
    return d - round(d);
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return TaskState(pose.xy, pose.z, 0.0);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var state = before;
    let total = cycles(episode);
    let away = distance(now.end.xy, state.home);
    var reward = 0.0;

    if (now.step < total / 2u) {
        if (away > state.excursion) {
            reward += (away - state.excursion) / FAR;
            state.excursion = away;
        }
    } else if (now.step + 1u == total) {
        // The error on the last cycle decides.
        let error = away / max(state.excursion, 1.0);
        let twist = abs(turn_difference(now.end.z, state.home_heading)) * 2.0;
        reward += state.excursion / FAR * (3.0 / (1.0 + 4.0 * error * error));
        reward += 0.5 * (1.0 - twist) * step(error, 0.1);
    } else {
        let closing = distance(now.start.xy, state.home) - away;
        reward += 0.2 * closing / FAR;
    }
    return Reward(reward, state);
}
