// finite-constants: a subnormal number
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = 1e-40f;
    return Reward(x, before);
}
