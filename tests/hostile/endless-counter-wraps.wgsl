// loop-without-bound: a counter that begins again from 0
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    for (var i = 0u; i <= 4294967295u; i++) { x += 1.0f; }
    return Reward(x, before);
}
