// float-bits: the sign of zero, which a driver may drop
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = f32(bitcast<u32>(x * 0.0f) >> 31u);
    return Reward(x, before);
}
