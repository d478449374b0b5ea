// The interface between tasks and physics. A task is a part that declares:
//
//     struct TaskState                                         its memory during a life
//     fn task_begin(life: Life, pose: vec3<f32>) -> TaskState  that memory at the start of a life
//     fn task_kept(own: TaskState) -> TaskState                the memory with every float passed through `stored`
//     fn task_cycle(life: Life, now: Experience, before: TaskState) -> Reward
//     fn task_ends(own: TaskState) -> bool                     whether to end the life early
//     fn task_score(own: TaskState, sum: f32) -> f32           the fitness, given the sum of all rewards

// A robot's cycle, as a task sees it. Poses are x and y in mm, and the heading in turns.
struct Experience {
    step: u32,
    start: vec3<f32>,
    end: vec3<f32>,
    // activations before and after sensor noise
    real: Readings,
    perceived: Readings,
    // outputs of the controller, and the motion that they command
    outputs: vec2<f32>,
    moved: Motion,
    // whether the cycle ends in a collision
    collided: bool,
}

// Reward of a cycle, and the task's memory after it.
struct Reward {
    earned: f32,
    state: TaskState,
}
