// finite-constants: what is not a number
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = bitcast<f32>(0x7fc00000u);
    return Reward(x, before);
}
