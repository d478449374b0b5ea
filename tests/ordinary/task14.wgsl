// Random goals one after another; reaching one early in the episode counts more.
const GOAL_RADIUS: f32 = 60.0;
const GOALS_WANTED: u32 = 5u;
const WORLD_SIZE = vec2<f32>(1000.0, 800.0);

struct TaskState {
    goal: vec2<f32>,
    reached: u32,
    since: u32,
}

fn new_goal(episode: Episode, step: u32, number: u32) -> vec2<f32> {
    let r = random(episode, STREAM_TASK, step, number);
    return mix(vec2<f32>(100.0), WORLD_SIZE - 100.0, r.xy);
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return TaskState(new_goal(episode, 0u, 0u), 0u, 0u);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var state = before;
    var reward = 0.0;
    let progress = distance(now.start.xy, state.goal) - distance(now.end.xy, state.goal);
    reward += progress / 1000.0;
    let time = f32(now.step) / f32(cycles(episode));
    if (distance(now.end.xy, state.goal) < GOAL_RADIUS) {
        let taken = now.step - state.since;
        reward += pow(1.0 - time, 2.0) + exp(-f32(taken) / 100.0);
        state.reached += 1u;
        state.since = now.step;
        state.goal = new_goal(episode, now.step, state.reached);
    }
    return Reward(reward, state);
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
    return memory.reached >= GOALS_WANTED;
}
