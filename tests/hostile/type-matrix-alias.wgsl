// supported-types: a matrix by another name
alias M = mat2x2f;

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let m = M(1.0f, 0.0f, 0.0f, 1.0f);
    return Reward(x, before);
}
