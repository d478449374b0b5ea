// exact-functions: the same, with a comment before the bracket
const C: f32 = sin/* */(1.0f);

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = C;
    return Reward(x, before);
}
