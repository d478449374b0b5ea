// own-buffers: a buffer of the part's
@group(0) @binding(9) var<storage, read_write> mine: array<f32>;

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = mine[0];
    return Reward(x, before);
}
