// kernel-buffers: a buffer in a function that nothing calls
fn first() -> f32 { return fitness[0]; }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
