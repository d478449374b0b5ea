// kernel-buffers: the trace of another
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = trace[0].record.x;
    return Reward(x, before);
}
