// episode-as-given: the same when a life is scored
alias L = Life;
fn task_score(life: Life, own: TaskState, sum: f32) -> f32 {
    return body_radius(L(1u, vec2<u32>(0u, 0u), 0u));
}

fn task_cycle(life: Life, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
