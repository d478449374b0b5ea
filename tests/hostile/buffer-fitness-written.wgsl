// kernel-buffers: writes the fitness of another
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    fitness[1] = 9.0f;
    return Reward(x, before);
}
