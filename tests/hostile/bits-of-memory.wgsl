// float-bits: the sign of a zero that is remembered, which is lost where a life is cut
struct TaskState { zero: f32 }
fn task_begin(life: Life, pose: vec3<f32>) -> TaskState {
    return TaskState(-0.0f * pose.x);
}
fn task_cycle(life: Life, now: Experience, before: TaskState) -> Reward {
    return Reward(f32(bitcast<u32>(before.zero) >> 31u), before);
}
