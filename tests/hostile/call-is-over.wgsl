// allowed-calls: a function of Oneiro's that takes what it is given
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = select(0.0f, 1.0f, is_over(episode, EpisodeState()));
    return Reward(x, before);
}
