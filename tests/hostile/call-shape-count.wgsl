// allowed-calls: a function of Oneiro's that takes what it is given
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = f32(shape_count(1u));
    return Reward(x, before);
}
