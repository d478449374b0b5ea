// A task: what a robot earns in each cycle of 100 ms. Change it as you like; `oneiro check` says what is wrong, and where.
// docs/extend.md lists all that a task learns of a cycle, and the functions that it may call.
//
// As it stands: get far away from the start, and rather not bump into anything.

// Values that an experiment may set, in [task.values]. Each has a comment: DEFAULT, LEAST to GREATEST UNIT: MEANING.
struct TaskValues {
    goal: f32, // 250, 10 to 10000 mm: distance from the start at which the episode is over
    bump: f32, // 0.5, 0 to 100: what a collision costs
}

// What the task remembers during an episode.
struct TaskState {
    start: vec2<f32>,
    farthest: f32,
    arrived: u32,
}

// The same at the start of an episode. The pose is x and y in mm, and the heading in turns.
fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return TaskState(pose.xy, 0.0, 0u);
}

// What a cycle earns, and what the task remembers of it.
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let own = task_values(episode);
    let away = distance(now.end.xy, before.start);
    var next = before;
    next.farthest = max(before.farthest, away);
    next.arrived = select(0u, 1u, away >= own.goal);
    return Reward(next.farthest - before.farthest - select(0.0, own.bump, now.collided), next);
}

// Whether the episode is over before its time.
fn task_ends(episode: Episode, own: TaskState) -> bool {
    return own.arrived != 0u;
}

// The fitness, of what all cycles earned in sum.
fn task_score(episode: Episode, own: TaskState, sum: f32) -> f32 {
    return sum;
}
