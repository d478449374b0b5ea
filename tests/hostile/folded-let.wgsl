// exact-functions: a value that is folded
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let c = cos(1.0f);
    x = c * 2.0f;
    return Reward(x, before);
}
