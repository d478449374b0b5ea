// unknown-name: a diagnostic that is turned off
diagnostic(off, derivative_uniformity);
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
