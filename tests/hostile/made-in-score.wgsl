// episode-as-given: the same when an episode is scored
alias L = Episode;
fn task_score(episode: Episode, own: TaskState, sum: f32) -> f32 {
    return body_radius(L(1u, vec2<u32>(0u, 0u), 0u, 0u));
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
