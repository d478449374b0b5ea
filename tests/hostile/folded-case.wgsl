// exact-functions: a case of a switch
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    switch now.step { case u32(8.0f * sin(1.0f)) { x = 1.0f; } default {} }
    return Reward(x, before);
}
