// no-override: a constant that a driver sets
override f: f32 = 2.0f;

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = f;
    return Reward(x, before);
}
