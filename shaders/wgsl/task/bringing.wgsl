// Food is brought to the nest: equation 1 of O'Dowd, Studley and Winfield (2014), for any controller of a forager.

// No struct is empty.
struct TaskState {
    unused: u32,
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return TaskState(0u);
}

fn task_kept(memory: TaskState) -> TaskState {
    return memory;
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    return Reward(now.worth, before);
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
    return false;
}

fn task_score(episode: Episode, memory: TaskState, sum: f32) -> f32 {
    return sum;
}
