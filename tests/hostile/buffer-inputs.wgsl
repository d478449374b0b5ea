// kernel-buffers: reads a buffer
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = f32(inputs[9] & 255u);
    return Reward(x, before);
}
