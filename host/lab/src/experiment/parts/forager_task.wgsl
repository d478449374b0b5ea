// A task: what a forager earns in each cycle of 100 ms. Change it as you like; `oneiro check` says what is wrong, and where.
// docs/extend.md lists all that a task learns of a cycle, and the functions that it may call.
//
// As it stands: bring as much food as possible, and get a little for each step of the way.

// Values that an experiment may set, in [task.values]. Each has a comment: DEFAULT, LEAST to GREATEST UNIT: MEANING.
struct TaskValues {
    way: f32, // 0.01, 0 to 1: what a millimetre nearer to food earns, or nearer to the nest with food
    bump: f32, // 0.1, 0 to 100: what a cycle at the wall costs
}

// What the task remembers during an episode.
struct TaskState {
    brought: u32,
    carries: u32,
    way: f32,
}

// What a cycle earns, and what the task remembers of it.
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let own = task_values(episode);
    var next = before;
    next.brought += select(0u, 1u, now.brought);
    next.carries = select(select(before.carries, 0u, now.brought), 1u, now.took);
    next.way = select(now.to_food, now.to_nest, next.carries != 0u);
    // The goal changes where food is taken or brought.
    let nearer = select(before.way - next.way, 0.0, now.took | now.brought | (now.step == 0u));
    let earned = own.way * nearer + select(0.0, 100.0, now.brought);
    return Reward(earned - select(0.0, own.bump, now.collided), next);
}
