// Find the cylinder and stay near it: each cycle near it earns 1, and the first collision, with it or with a wall, ends the episode.
// An episode that begins near it earns nothing until the robot has been away.

struct TaskValues {
    x: f32, // 200, 0 to 100000 mm: of the centre of the cylinder, which the experiment places
    y: f32, // 150, 0 to 100000 mm: of the same
    reach: f32, // 100, 1 to 100000 mm: distance between the centres of robot and cylinder, below which a cycle earns
}

struct TaskState {
    was_away: u32,
    collided: u32,
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return TaskState(select(1u, 0u, is_beside(episode, pose)), 0u);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let beside = is_beside(episode, now.end);
    let earned = select(0.0f, 1.0f, beside & !now.collided & (before.was_away != 0u));
    return Reward(earned, TaskState(select(1u, before.was_away, beside), select(0u, 1u, now.collided)));
}

fn task_ends(episode: Episode, own: TaskState) -> bool {
    return own.collided != 0u;
}

fn is_beside(episode: Episode, pose: vec3<f32>) -> bool {
    let own = task_values(episode);
    let to = vec2<f32>(own.x - pose.x, own.y - pose.y);
    return squared_length(to) < own.reach * own.reach;
}
