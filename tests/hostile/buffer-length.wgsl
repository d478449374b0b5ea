// kernel-buffers: the length of a buffer, which depends on the batch
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = f32(arrayLength(&fitness));
    return Reward(x, before);
}
