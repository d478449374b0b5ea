// Visit all patches of the floor in their order, again and again. Fitness: the number of visits, and the share of the way to the next
// patch, less what collisions cost.

struct TaskValues {
    bump: f32, // 0, 0 to 1000: cost of a cycle that ends in a collision
}

struct TaskState {
    goal: u32,
    way: f32,
    nearest: f32,
}

// On the way to a patch.
fn towards(episode: Episode, goal: u32, place: vec2<f32>) -> TaskState {
    let way = max(distance(place, arena_patch(episode, goal).place), 1.0);
    return TaskState(goal, way, way);
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return towards(episode, 0u, pose.xy);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var next = before;
    next.nearest = min(before.nearest, distance(now.end.xy, arena_patch(episode, before.goal).place));
    var earned = (before.nearest - next.nearest) / before.way;
    if on_patch(episode, before.goal, now.end.xy) {
        // The rest of the way, to the patch's middle, counts as made.
        earned += next.nearest / before.way;
        let following = before.goal + 1u;
        next = towards(episode, select(following, 0u, following >= arena_patches(episode)), now.end.xy);
    }
    if now.collided {
        earned -= task_values(episode).bump;
    }
    return Reward(earned, next);
}
