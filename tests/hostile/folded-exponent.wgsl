// exact-functions: the same, after a number that looks like one with an exponent
const C: f32 = 0xE+sin(1.0f);

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = C;
    return Reward(x, before);
}
