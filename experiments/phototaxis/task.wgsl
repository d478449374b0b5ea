// Be in the light: each cycle earns the brighter reading of the two light sensors, before noise, as a share of the episode.

struct TaskValues {
    cycles: f32, // 300, 1 to 100000: those of an episode, so that the greatest fitness is 1
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let light = max(now.real.light_left, now.real.light_right);
    return Reward(light * reciprocal(task_values(episode).cycles), before);
}
