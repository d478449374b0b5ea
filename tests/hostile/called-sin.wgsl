// exact-functions: a function that each device has its own of
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = sin(x);
    return Reward(x, before);
}
