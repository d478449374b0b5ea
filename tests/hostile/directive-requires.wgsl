// valid-wgsl: a feature of the language
requires readonly_and_readwrite_storage_textures;
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    
    return Reward(x, before);
}
