// Follow walls: a robot earns the way that it drives forwards, the more the nearer it keeps to a given distance from the nearest wall,
// obstacle or block. Fitness: that way in metres, less what collisions cost.

struct TaskValues {
    gap: f32, // 30, 1 to 10000 mm: distance that the body should keep
    width: f32, // 30, 1 to 10000 mm: how far off it earns nothing
    bump: f32, // 0.05, 0 to 1000: cost of a cycle that ends in a collision
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let own = task_values(episode);
    let off = abs(clearance(episode, now.end.xy, own.gap + own.width) - own.gap);
    var earned = max(1.0 - off / own.width, 0.0) * max(now.moved.displacement, 0.0) / 1000.0;
    if now.collided {
        earned -= own.bump;
    }
    return Reward(earned, before);
}
