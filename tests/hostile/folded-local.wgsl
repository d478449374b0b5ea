// exact-functions: a constant of a function
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    const c = sin(1.0f);
    x = c * 2.0f;
    return Reward(x, before);
}
