// allowed-calls: a function of Oneiro's that takes what it is given
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = toward(7u, now.end.xy).x;
    return Reward(x, before);
}
