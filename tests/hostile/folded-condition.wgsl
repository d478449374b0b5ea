// exact-functions: the same, in a condition
const C: f32 = select(1.0f, 2.0f, sin(1.0f) > 0.5f);

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = C;
    return Reward(x, before);
}
