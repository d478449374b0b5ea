// built-in-name: a name of WGSL's that Oneiro's files use
fn abs(x: f32) -> f32 { return x; }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
