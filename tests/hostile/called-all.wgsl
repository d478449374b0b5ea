// exact-functions: a function that isn't the same on every device, or mixes episodes
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = select(0.0f, 1.0f, all(now.end.xy > now.start.xy));
    return Reward(x, before);
}
