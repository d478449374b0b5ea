// state-types: an episode in a task's memory
struct TaskState { who: Life }
fn task_cycle(life: Life, now: Experience, before: TaskState) -> Reward {
    return Reward(body_radius(before.who), before);
}
