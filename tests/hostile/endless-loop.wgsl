// loop-without-bound: a loop without an end
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    loop {
        x += 1.0f;
        if x < 0.0f { break; }
    }
    return Reward(x, before);
}
