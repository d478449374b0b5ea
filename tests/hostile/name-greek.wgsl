// ascii-source (harmless): a name with a letter that looks like another
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let οne = 1.0f;
    x = οne;
    return Reward(x, before);
}
