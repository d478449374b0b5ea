// supported-types: floats of 16 bits
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let y = f16(1.0f);
    return Reward(x, before);
}
