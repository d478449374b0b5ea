// ascii-source (harmless): a name with a mark on it
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let é = 1.0f;
    return Reward(x, before);
}
