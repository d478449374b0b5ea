// loop-without-bound: a counter that is changed through a pointer
fn reset(p: ptr<function, u32>) { *p = 0u; }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    for (var i = 0u; i < 9u; i++) {
        reset(&i);
        x += 1.0f;
    }
    return Reward(x, before);
}
