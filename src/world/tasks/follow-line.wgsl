// Follow a line on the floor: a robot earns the way that it drives forwards while its middle is on the line. Fitness: that way in
// metres, less what collisions cost.

struct TaskValues {
    dark: f32, // 0.5, 0 to 1: the floor is the line where its grey is below this
    bump: f32, // 0, 0 to 1000: cost of a cycle that ends in a collision
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let own = task_values(episode);
    var earned = 0.0;
    if floor_at(episode, now.end.xy) < own.dark {
        earned += max(now.moved.displacement, 0.0) / 1000.0;
    }
    if now.collided {
        earned -= own.bump;
    }
    return Reward(earned, before);
}
