// ascii-source: a no-break space
fn task_cycle(life: Life, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = 1.0f;
    return Reward(x, before);
}
