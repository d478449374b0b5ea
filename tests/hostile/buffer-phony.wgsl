// kernel-buffers: a buffer that is only looked at
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    _ = inputs[0];
    return Reward(x, before);
}
