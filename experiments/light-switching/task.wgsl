// Earn the fraction of cycles that the robot is on the grey patch under the lamp while the lamp is on (Floreano and Urzelai 2000). Nothing is
// earned for the switch itself.

struct TaskState {
    on: u32,
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return TaskState(0u);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let on = select(before.on, 1u, on_patch(episode, 0u, now.end.xy));
    let is_earning = (on == 1u) & on_patch(episode, 1u, now.end.xy);
    return Reward(select(0.0, 1.0 / f32(cycles(episode)), is_earning), TaskState(on));
}
