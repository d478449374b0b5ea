// large-variable: a field of a megabyte
struct TaskState { @size(1000000) x: f32 }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
