// valid-wgsl: a function that calls itself
fn again(x: f32) -> f32 { return again(x); }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = again(x);
    return Reward(x, before);
}
