// float-bits: the sign of a zero that is remembered, which is lost where an episode is cut
struct TaskState { zero: f32 }
fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return TaskState(-0.0f * pose.x);
}
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    return Reward(f32(bitcast<u32>(before.zero) >> 31u), before);
}
