// exact-functions: the length of an array
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    var a: array<f32, u32(exp(1.0f))>;
    x = a[1];
    return Reward(x, before);
}
