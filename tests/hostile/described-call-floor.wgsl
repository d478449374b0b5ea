// allowed-calls: a function of described robots that takes what it is given
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = select(0.0f, 1.0f, is_on_patch(1u, 0u, now.end.xy));
    return Reward(x, before);
}
