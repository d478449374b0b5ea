// allowed-calls: a function of foragers that takes what it is given
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = select(0.0f, 1.0f, harvest(episode, 0u, now.end.xy, Food(), false).took);
    return Reward(x, before);
}
