// supported-types: a matrix of halves
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let m = mat2x2<f16>(1.0h, 0.0h, 0.0h, 1.0h);
    return Reward(x, before);
}
