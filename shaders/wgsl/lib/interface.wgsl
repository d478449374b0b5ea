// The interface between physics and the parts that a user may write. Sensors are read, the controller commands the wheels,
// physics move the robot, and the task rewards the cycle. Each part has a memory, passed from cycle to cycle. A
// part's `.._kept` passes every float of its memory through `stored`.
//
// Sensors besides the eight of proximity declare:
//
//     const OWN_READINGS: u32                                      number of readings
//     struct SensorReadings                                        one f32 per reading
//     struct SensorState
//     fn sensor_begin(episode: Episode, pose: vec3<f32>) -> SensorState
//     fn sensor_kept(memory: SensorState) -> SensorState
//     fn sensor_ends(episode: Episode, memory: SensorState) -> bool      whether to end the episode early, of users' parts
//     fn sensors_read(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed
//     fn plus_weighed(episode: Episode, index: u32, custom: SensorReadings, sum: f32) -> f32
//                                          `sum`, and each reading times its gene; gene `index` weighs the first
//
// A controller declares:
//
//     struct ControllerState
//     fn controller_begin(episode: Episode) -> ControllerState
//     fn controller_kept(memory: ControllerState) -> ControllerState
//     fn controller_ends(episode: Episode, memory: ControllerState) -> bool      likewise
//     fn commands(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command
//
// A task declares:
//
//     struct TaskState
//     fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState
//     fn task_kept(memory: TaskState) -> TaskState
//     fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward
//     fn task_ends(episode: Episode, memory: TaskState) -> bool          whether to end the episode early
//     fn task_score(episode: Episode, memory: TaskState, sum: f32) -> f32
//                                          the fitness, given the sum of all rewards

// Readings of a user's sensors, and their memory after a cycle.
struct Sensed {
    readings: SensorReadings,
    state: SensorState,
}

// Outputs of the controller for the left and the right motor, each in [0, 1], and its memory after a cycle.
struct Command {
    outputs: vec2<f32>,
    state: ControllerState,
}

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
