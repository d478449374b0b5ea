// exact-functions: a barrier
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    workgroupBarrier();
    return Reward(x, before);
}
