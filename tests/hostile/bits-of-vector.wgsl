// float-bits: the bits of several floats
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    let bits = bitcast<vec3<u32>>(now.end);
    x = f32(bits.x & 255u);
    return Reward(x, before);
}
