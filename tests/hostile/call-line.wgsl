// allowed-calls: a call with a line before its bracket
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = select(0.0f, 1.0f, touches

        (1u, now.end.xy));
    return Reward(x, before);
}
