// built-in-name: a name of WGSL's that Oneiro's files use
fn clamp(x: f32, a: f32, b: f32) -> f32 { return x; }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
