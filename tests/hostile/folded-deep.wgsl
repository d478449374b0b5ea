// exact-functions: the same, in a larger constant
const C: f32 = 2.0f * (1.0f + sin(1.0f));

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = C;
    return Reward(x, before);
}
