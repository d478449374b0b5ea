// kernel-buffers: reads a buffer
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = fitness[1];
    return Reward(x, before);
}
