// float-bits: the bits of a float in another function
fn sign_of(x: f32) -> f32 { return f32(bitcast<u32>(x) >> 31u); }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = sign_of(x);
    return Reward(x, before);
}
