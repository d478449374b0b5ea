// reserved-name: what stores a memory
fn task_kept(own: TaskState) -> TaskState { return own; }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
