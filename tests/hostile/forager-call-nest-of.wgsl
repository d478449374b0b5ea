// allowed-calls: a function of foragers that takes what it is given
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = nest_of(1u).x;
    return Reward(x, before);
}
