// exact-functions: a function that isn't the same on every device, or mixes episodes
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = f32(pack2x16float(now.end.xy));
    return Reward(x, before);
}
