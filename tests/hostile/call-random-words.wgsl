// allowed-calls: a function of Oneiro's that takes what it is given
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = f32(random_words(vec2<u32>(1u, 2u), 0u, 0u, 0u).x);
    return Reward(x, before);
}
