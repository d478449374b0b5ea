// A goal that jumps to a random place every so often. Being there counts
// more the later in the episode it is.

const PERIOD = 150u;
const MARGIN = 100.0;
const ARENA = 1000.0;

struct TaskState {
    goal: vec2<f32>,
    reached: u32,
}

fn pick_goal(episode: Episode, step: u32) -> vec2<f32> {
    let r = random(episode, STREAM_TASK, step, 0u);
    return mix(vec2<f32>(MARGIN), vec2<f32>(ARENA - MARGIN), r.xy);
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return TaskState(pick_goal(episode, 0u), 0u);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var state = before;
    if (now.step > 0u && now.step % PERIOD == 0u) {
        state.goal = pick_goal(episode, now.step);
    }

    let time = f32(now.step) / f32(cycles(episode));
    let weight = 0.5 + time * time;

    let distance = length(state.goal - now.end.xy);
    var reward = weight * exp(-distance / 120.0);
    if (distance < 50.0) {
        state.reached++;
        state.goal = pick_goal(episode, now.step + 1u);
        reward += 3.0 * weight;
    }
    return Reward(reward, state);
}
