// float-bits: the sign of a zero of Oneiro's
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = f32(bitcast<i32>(now.end.z) >> 31u);
    return Reward(x, before);
}
