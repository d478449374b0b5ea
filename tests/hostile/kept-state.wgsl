// state-types: an episode in a task's memory
struct TaskState { who: Episode }
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    return Reward(body_radius(before.who), before);
}
