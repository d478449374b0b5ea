// exact-functions: an attribute
struct Odd { @size(u32(4.0f * exp(1.0f))) x: f32 }

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
