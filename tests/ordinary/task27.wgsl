// Follow a figure eight (a lemniscate of Gerono). A carrot runs along the
// curve whenever the robot is close enough to it.

const TAU: f32 = 6.28318530718;
const SIZE = vec2<f32>(350.0, 200.0);
const MIDDLE = vec2<f32>(500.0, 500.0);
const CATCH: f32 = 100.0;

struct TaskState {
    phase: f32,
    loops: u32,
}

fn curve(phase: f32) -> vec2<f32> {
    let t = phase * TAU;
    return MIDDLE + SIZE * vec2<f32>(cos(t), sin(2.0 * t));
}

fn tangent(phase: f32) -> vec2<f32> {
    let t = phase * TAU;
    return normalize(SIZE * vec2<f32>(-sin(t), 2.0 * cos(2.0 * t)));
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var state = before;
    let carrot = curve(state.phase);
    let gap = distance(now.end.xy, carrot);

    let advance = (1.0 - smoothstep(0.5 * CATCH, CATCH, gap)) * 0.004;
    state.phase += advance;
    if (state.phase >= 1.0) {
        state.phase -= 1.0;
        state.loops += 1u;
    }

    let angle = now.end.z * TAU;
    let facing = vec2<f32>(cos(angle), sin(angle));
    let aligned = 0.5 + 0.5 * dot(facing, tangent(state.phase));

    let reward = 100.0 * advance * aligned - 0.5 * f32(now.collided);
    return Reward(reward, state);
}
