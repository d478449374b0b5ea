// allowed-calls: a function of described robots that takes what it is given
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = drive_of(1u).cycles;
    return Reward(x, before);
}
