// exact-functions: a constant that is folded by the build machine's library
const C: f32 = atan2(1.0f, 2.0f);

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = C;
    return Reward(x, before);
}
