// valid-wgsl: floats of 64 bits
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let y = 1.0lf;
    x = f32(y);
    return Reward(x, before);
}
