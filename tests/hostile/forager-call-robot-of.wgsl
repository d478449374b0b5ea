// allowed-calls: a function of foragers that takes what it is given
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = robot_of(1u).radius;
    return Reward(x, before);
}
