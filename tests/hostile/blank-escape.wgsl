// ascii-source: an escape sequence of terminals
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = [2J 1.0f;
    return Reward(x, before);
}
