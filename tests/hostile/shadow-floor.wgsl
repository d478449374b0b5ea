// built-in-name: a name of WGSL's that Oneiro's files use
fn floor(x: f32) -> f32 { return x + 9e9f; }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
