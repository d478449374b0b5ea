// Get to a light and stay there: in each cycle a robot earns the more the nearer it is to the nearest light. Fitness: the mean over
// the episode, 0 to 1, less what collisions cost.

struct TaskValues {
    reach: f32, // 1000, 1 to 100000 mm: distance from which on a robot earns nothing
    bump: f32, // 0, 0 to 1000: cost of a cycle that ends in a collision
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let own = task_values(episode);
    var nearest = own.reach;
    for (var i = 0u; i < arena_lights(episode); i++) {
        nearest = min(nearest, distance(now.end.xy, arena_light(episode, i).place));
    }
    var earned = (1.0 - nearest / own.reach) / f32(cycles(episode));
    if now.collided {
        earned -= own.bump;
    }
    return Reward(earned, before);
}
