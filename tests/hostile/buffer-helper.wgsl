// kernel-buffers: a buffer in another function
fn first() -> f32 { return fitness[0]; }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = first();
    return Reward(x, before);
}
