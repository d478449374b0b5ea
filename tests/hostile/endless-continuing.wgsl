// loop-without-bound: a loop whose end is in `continuing`
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    loop {
        continuing { x += 1.0f; break if x < 0.0f; }
    }
    return Reward(x, before);
}
