// loop-without-bound: a `continue` skips the step
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var i = 0u;
    while (i < 9u) {
        if (now.moved.left > 0.5f) { continue; }
        i++;
    }
    return Reward(f32(i), before);
}
