// kernel-buffers: the state of another
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = state[1].fitness;
    return Reward(x, before);
}
