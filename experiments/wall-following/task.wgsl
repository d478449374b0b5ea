// Drive along the wall on the right, fast and at a set distance: each cycle earns the speed forward times how near the distance
// is, as a share of the episode. A collision earns nothing.

struct TaskValues {
    distance: f32, // 80, 1 to 100000 mm: from the robot's centre to what is on its right, square to its heading
    width: f32, // 40, 1 to 100000 mm: how far off that distance still earns something
    cycles: f32, // 600, 1 to 100000: those of an episode, so that the greatest fitness is 1
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let own = task_values(episode);
    let at = vec2<f32>(now.end.x, now.end.y);
    let distance = distance_along(episode, at, now.end.z - 0.25f, own.distance + own.width);
    let near = max(1.0f - abs(distance - own.distance) * reciprocal(own.width), 0.0f);
    let speed = max(0.5f * (now.moved.left + now.moved.right), 0.0f);
    return Reward(select(near * speed, 0.0f, now.collided) * reciprocal(own.cycles), before);
}
