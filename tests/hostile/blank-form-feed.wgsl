// ascii-source (harmless): a comment that a form feed ends
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    // nothing    x = 1.0f;
    return Reward(x, before);
}
