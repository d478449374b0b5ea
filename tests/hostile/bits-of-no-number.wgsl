// float-bits: the bits of what is not a number
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let large = 3e38f * (now.end.x + 9.0f);
    x = f32(bitcast<u32>(large - large) & 1023u);
    return Reward(x, before);
}
