// built-in-name: a name of WGSL's that Oneiro's files use
fn select(a: f32, b: f32, c: bool) -> f32 { return a; }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
