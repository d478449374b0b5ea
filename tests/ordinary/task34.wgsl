// Cover ground with little curvature and little jerk in the wheels.

const TAU = 6.2831853;
const CURVATURE_COST = 40.0;
const JERK_COST = 0.15;

struct TaskState {
    wheels: vec2<f32>,
    curvature: f32,
}

fn turned(a: f32, b: f32) -> f32 {
    return fract(b - a + 0.5) - 0.5;
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let path = max(length(now.end.xy - now.start.xy), 1e-3);
    let bend = TAU * abs(turned(now.start.z, now.end.z));
    let curvature = min(bend / path, 0.1);

    let wheels = vec2<f32>(now.moved.left, now.moved.right);
    let jerk = wheels - before.wheels;

    var state: TaskState;
    state.wheels = wheels;
    state.curvature = 0.9 * before.curvature + 0.1 * curvature;

    var reward = path / 10.0;
    reward -= CURVATURE_COST * state.curvature * state.curvature;
    reward -= JERK_COST * dot(jerk, jerk);
    if (now.collided) { reward = -1.0; }
    return Reward(clamp(reward, -1.0, 1.0), state);
}
