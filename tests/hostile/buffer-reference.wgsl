// kernel-buffers: a reference to a buffer
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let p = &inputs;
    x = f32((*p)[3] & 255u);
    return Reward(x, before);
}
