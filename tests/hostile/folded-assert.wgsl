// exact-functions: an assertion that another machine may refuse
const_assert sin(1.0f) > 0.5f;

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
