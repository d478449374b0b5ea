// allowed-calls: a function of Oneiro's that takes what it is given
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = sense(1u, now.end, now.end.xy, now.real.own).first.x;
    return Reward(x, before);
}
