// allowed-calls: a function of Oneiro's that takes what it is given
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = ray_to_shape(7u, now.end.xy, now.end.xy, 9.0f);
    return Reward(x, before);
}
