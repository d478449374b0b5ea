// batch-place: the number of a world
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = f32(episode.world);
    return Reward(x, before);
}
