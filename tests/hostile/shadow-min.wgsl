// built-in-name: a name of WGSL's that Oneiro's files use
fn min(a: u32, b: u32) -> u32 { return a; }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
