// kernel-buffers: a buffer that is passed on
fn first(p: ptr<storage, array<u32>, read>) -> f32 { return f32((*p)[3] & 255u); }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = first(&inputs);
    return Reward(x, before);
}
