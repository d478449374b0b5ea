// entry-point: an entry point of another stage
@vertex
fn other() -> @builtin(position) vec4<f32> { return vec4<f32>(); }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
