// episode-as-given: a task in another world
alias L = Episode;

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = body_radius(L(1u, vec2<u32>(0u, 0u), 0u, 0u));
    return Reward(x, before);
}
