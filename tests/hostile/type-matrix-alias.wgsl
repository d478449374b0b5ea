// supported-types: a matrix of halves by another name
alias M = mat2x2h;

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let m = M(1.0h, 0.0h, 0.0h, 1.0h);
    return Reward(x, before);
}
