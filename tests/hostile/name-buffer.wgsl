// ascii-source (harmless): a name that only looks like a buffer's
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let wоrlds = 1.0f;
    return Reward(x, before);
}
