// exact-functions: the same, as an integer
const C: f32 = f32(u32(1000.0f * sin(1.0f)));

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = C;
    return Reward(x, before);
}
