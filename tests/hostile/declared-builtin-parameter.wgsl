// valid-wgsl: a parameter that a driver fills
fn at(@builtin(workgroup_id) group: vec3<u32>) -> u32 { return group.x; }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
