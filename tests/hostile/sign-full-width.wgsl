// ascii-source: a bracket of another width
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = abs（x）;
    return Reward(x, before);
}
