// Bring food to the nest: one patch of the floor is the nest, and every other one has food that never runs out. A robot takes food when
// it gets there, and brings it when it gets to the nest. Fitness: what taking and bringing earned, less what collisions cost.

struct TaskValues {
    nest: f32, // 0, 0 to 4095: number of the patch that is the nest, from 0
    take: f32, // 0.5, 0 to 1000: what taking food earns
    bring: f32, // 1, 0 to 1000: what bringing it earns
    bump: f32, // 0, 0 to 1000: cost of a cycle that ends in a collision
}

struct TaskState {
    carries: u32,
    brought: u32,
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let own = task_values(episode);
    let nest = u32(own.nest);
    var next = before;
    var earned = 0.0;
    if before.carries == 1u && on_patch(episode, nest, now.end.xy) {
        next = TaskState(0u, before.brought + 1u);
        earned += own.bring;
    } else if before.carries == 0u && on_other_patch(episode, nest, now.end.xy) {
        next.carries = 1u;
        earned += own.take;
    }
    if now.collided {
        earned -= own.bump;
    }
    return Reward(earned, next);
}
