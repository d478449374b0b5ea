// allowed-calls: a function of Oneiro's that takes what it is given
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = noisy_motion(episode, 0u, now.moved).turn;
    return Reward(x, before);
}
