// What a task learns and says. A task is a part that has, besides:
//
//     struct TaskState                                         what it remembers during a life
//     fn task_begin(life: Life, pose: vec3<f32>) -> TaskState  the same at the start of a life
//     fn task_kept(own: TaskState) -> TaskState                the same with every number `stored`
//     fn task_cycle(life: Life, now: Experience, before: TaskState) -> Reward
//     fn task_ends(own: TaskState) -> bool                     whether the life is over before its time
//     fn task_score(own: TaskState, sum: f32) -> f32           the fitness, of what its cycles earned in sum

// One cycle of a robot: the poses at its start and its end (x and y in mm, heading in turns), and what lies between.
struct Experience {
    step: u32,
    start: vec3<f32>,
    end: vec3<f32>,
    // the activations before and after sensor noise
    real: Readings,
    perceived: Readings,
    // what the controller wants of its motors, and what that makes of them
    outputs: vec2<f32>,
    moved: Motion,
    // whether it ends in a collision
    collided: bool,
}

// What a cycle earns, and what the task remembers of it.
struct Reward {
    earned: f32,
    state: TaskState,
}
