// built-in-name (harmless): a name of WGSL's that no file of Oneiro's uses here
fn trunc(x: f32) -> f32 { return x; }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
