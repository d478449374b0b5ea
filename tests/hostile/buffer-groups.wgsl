// kernel-buffers: reads a buffer
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = f32(groups[0].rollouts);
    return Reward(x, before);
}
