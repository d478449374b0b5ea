// large-variable: an array of more than 64 KB
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    var a: array<f32, 16385>;
    x = a[3];
    return Reward(x, before);
}
