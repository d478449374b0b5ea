// large-variable: arrays of more than 64 KB together
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    var a: array<f32, 9000>;
    var b: array<f32, 9000>;
    for (var i = 0u; i < 9000u; i++) { a[i] = x; b[i] = a[i] + 1.0f; }
    for (var i = 0u; i < 9000u; i++) { x += a[i] + b[i]; }
    return Reward(x, before);
}
