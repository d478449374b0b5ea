// own-buffers: memory that episodes share
var<workgroup> shared_count: u32;

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    shared_count += 1u;
    return Reward(x, before);
}
