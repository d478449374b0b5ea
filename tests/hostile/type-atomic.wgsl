// supported-types: an atomic number
struct Count { n: atomic<u32> }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
