// allowed-calls: a function of described robots that takes what it is given
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = speed_of(wheels_of(1u), 0.5f);
    return Reward(x, before);
}
