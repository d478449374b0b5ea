// valid-wgsl: integers of 64 bits
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let y = 1lu;
    x = f32(y);
    return Reward(x, before);
}
