// Get to a patch of the floor. Fitness: the share of the way there that the robot has made, and if it arrives, the share of the time
// that is left: 0 to 2, less what collisions cost.

struct TaskValues {
    goal: f32, // 0, 0 to 4095: number of the patch, from 0
    bump: f32, // 0, 0 to 1000: cost of a cycle that ends in a collision
}

struct TaskState {
    way: f32,
    nearest: f32,
    arrived: u32,
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    let way = max(distance(pose.xy, arena_patch(episode, u32(task_values(episode).goal)).place), 1.0);
    return TaskState(way, way, 0u);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let own = task_values(episode);
    let goal = u32(own.goal);
    var next = before;
    var earned = 0.0;
    if before.arrived == 0u {
        next.nearest = min(before.nearest, distance(now.end.xy, arena_patch(episode, goal).place));
        earned += (before.nearest - next.nearest) / before.way;
        if on_patch(episode, goal, now.end.xy) {
            next.arrived = 1u;
            // The rest of the way, to the patch's middle, counts as made.
            earned += next.nearest / before.way + 1.0 - f32(now.step + 1u) / f32(cycles(episode));
        }
    }
    if now.collided {
        earned -= own.bump;
    }
    return Reward(earned, next);
}
