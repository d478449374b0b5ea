// batch-place: the number of a world
fn task_cycle(life: Life, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = f32(life.world);
    return Reward(x, before);
}
