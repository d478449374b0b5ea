// own-buffers: a global variable behind a comment that a carriage return ends
// nothingvar<private> count: u32;
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
