// state-types (compiled, it is a value like others): a matrix that is remembered
struct TaskState { turn: mat2x2<f32> }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    return Reward(before.turn[0].x, before);
}
