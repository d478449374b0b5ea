// Drive fast and keep away from walls; earn nothing on the charging patch, and die when the battery is empty (Floreano and
// Mondada 1996). Neither the battery nor the light is in the fitness: to return to the patch only makes episodes longer.

struct TaskValues {
    cycles: f32, // 600, 1 to 100000 cycles: by which the sum is divided
    measure: f32, // 0, 0 to 2: what is scored: 0 the paper's fitness, 1 how often it returned to the patch, 2 cycles lived
}

struct TaskState {
    // cycles that the battery lasts
    left: f32,
    charging: u32,
}

// Patch and battery are those of the sensors.
fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    let own = sensor_values(episode);
    let is_charging = squared_length(vec2<f32>(pose.x, pose.y)) < own.radius * own.radius;
    return TaskState(own.full, select(0u, 1u, is_charging));
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let own = task_values(episode);
    let sensors = sensor_values(episode);
    let is_charging = squared_length(vec2<f32>(now.end.x, now.end.y)) < sensors.radius * sensors.radius;
    var next = before;
    next.left = select(before.left - 1.0f, sensors.full, is_charging);
    next.charging = select(0u, 1u, is_charging);
    let speed = 0.5f * (abs(now.moved.left) + abs(now.moved.right));
    let earned = select(speed * (1.0f - highest(now.real)), 0.0f, is_charging) * reciprocal(own.cycles);
    let is_return = (own.measure == 1.0f) & is_charging & (before.charging == 0u);
    let other = select(select(0.0f, 1.0f, is_return), 1.0f, own.measure == 2.0f);
    return Reward(select(other, earned, own.measure == 0.0f), next);
}

fn task_ends(episode: Episode, own: TaskState) -> bool {
    return own.left <= 0.0f;
}
