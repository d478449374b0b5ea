// allowed-calls: a function of Oneiro's that takes what it is given
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = ray_in_world(1u, now.end.xy, 0.0f, 9.0f);
    return Reward(x, before);
}
