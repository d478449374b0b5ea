// ascii-source: a no-break space
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = 1.0f;
    return Reward(x, before);
}
