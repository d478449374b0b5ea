// loop-without-bound: a counter that is changed
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    for (var i = 0u; i < 9u; i++) { i = 0u; x += 1.0f; }
    return Reward(x, before);
}
