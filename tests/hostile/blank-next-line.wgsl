// ascii-source: a comment that a next line ends
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    // nothing    fitness[0] = 1.0f;
    return Reward(x, before);
}
