// kernel-buffers: reads a buffer
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = shapes[0].x;
    return Reward(x, before);
}
