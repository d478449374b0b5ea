// ascii-source: genes of others by the same blank
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = gene‎(episode, 5000u);
    return Reward(x, before);
}
