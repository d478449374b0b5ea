// ascii-source: a zero width space in a name
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let a​b = 1.0f;
    return Reward(x, before);
}
