// valid-wgsl: a function that calls its caller
fn again(life: Life, now: Experience, before: TaskState) -> f32 {
    return task_cycle(life, now, before).earned;
}

fn task_cycle(life: Life, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = again(life, now, before);
    return Reward(x, before);
}
