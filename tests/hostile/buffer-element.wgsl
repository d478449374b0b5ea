// kernel-buffers: a reference to an element
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let p = &fitness[3];
    *p = 1.0f;
    return Reward(x, before);
}
