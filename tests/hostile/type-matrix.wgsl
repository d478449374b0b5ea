// supported-types: a matrix
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let m = mat2x2<f32>(1.0f, 0.0f, 0.0f, 1.0f);
    return Reward(x, before);
}
