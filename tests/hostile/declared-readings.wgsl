// reserved-name: readings of another form
struct Readings { own: u32 }

fn task_cycle(life: Life, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
