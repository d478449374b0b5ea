// entry-point: an entry point
@compute @workgroup_size(64)
fn other() {}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
