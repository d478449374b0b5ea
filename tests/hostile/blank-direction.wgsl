// ascii-source: text that runs the other way
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let ‮a = 1.0f;
    return Reward(x, before);
}
