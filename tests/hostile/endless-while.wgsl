// loop-without-bound: a loop with a condition
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    while x > 0.0f { x *= 0.5f; }
    return Reward(x, before);
}
