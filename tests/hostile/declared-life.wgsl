// reserved-name: an episode of another form
struct Life { world: u32 }

fn task_cycle(life: Life, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
