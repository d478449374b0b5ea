// valid-wgsl: a function that calls its caller
fn again(episode: Episode, now: Experience, before: TaskState) -> f32 {
    return task_cycle(episode, now, before).earned;
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = again(episode, now, before);
    return Reward(x, before);
}
