// Patrol four posts. Each post grows more urgent the longer it is left alone.

const POSTS = 4u;
const REACH = 90.0;

struct TaskState {
    idle: vec4<f32>,
    visits: vec4<u32>,
}

fn post(index: u32) -> vec2<f32> {
    switch (index) {
        case 0u: { return vec2<f32>(150.0, 150.0); }
        case 1u: { return vec2<f32>(850.0, 150.0); }
        case 2u: { return vec2<f32>(850.0, 850.0); }
        default: { return vec2<f32>(150.0, 850.0); }
    }
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var state = before;
    var reward = 0.0;
    for (var i = 0u; i < POSTS; i += 1u) {
        state.idle[i] += 1.0;
        if (distance(now.end.xy, post(i)) < REACH) {
            reward += 1.0 - exp(-state.idle[i] / 200.0);
            if (state.idle[i] > 50.0) {
                state.visits[i] += 1u;
            }
            state.idle[i] = 0.0;
        }
    }
    // The most neglected post costs.
    let worst = max(max(state.idle.x, state.idle.y), max(state.idle.z, state.idle.w));
    reward -= 0.001 * smoothstep(300.0, 1000.0, worst);
    return Reward(reward, state);
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
    return all(memory.visits >= vec4<u32>(5u));
}
