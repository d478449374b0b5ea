// exact-functions: a function that isn't the same on every device, or mixes episodes
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = dpdx(x);
    return Reward(x, before);
}
