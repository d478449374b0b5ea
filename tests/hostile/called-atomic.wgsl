// exact-functions: an atomic operation
var<private> count: u32;

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    atomicAdd(&count, 1u);
    return Reward(x, before);
}
