// kernel-buffers: reads a buffer
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = f32(dispatch.trace_every);
    return Reward(x, before);
}
