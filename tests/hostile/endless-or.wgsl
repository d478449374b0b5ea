// loop-without-bound: the counter's test is one of two that go on
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var i = 0u;
    while (i < 9u || now.moved.left > 0.5f) { i++; }
    return Reward(f32(i), before);
}
