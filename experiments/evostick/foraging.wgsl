// FOR: a robot on a black spot has an item, one at a time, and brings it to the white nest for a point (Francesca et al. 2014). A
// robot's own score is what it brought.
struct TaskState {
    has_item: u32,
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let floor = floor_at(episode, now.end.xy);
    let is_home = floor > 0.9f;
    let had_item = before.has_item != 0u;
    let has_item = (floor < 0.1f) | (!is_home & had_item);
    return Reward(select(0.0f, 1.0f, is_home & had_item), TaskState(u32(has_item)));
}
