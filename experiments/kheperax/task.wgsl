// The tasks of Kheperax. With a target, each cycle costs the distance to it, and the episode ends there. Without, each costs the
// sum of the squared distances that the wheels travel, and only the place where an episode ends tells policies apart. The unit of
// length is the side of the maze.

struct TaskValues {
    goal: f32, // 1, 0 to 1: 1 with a target, 0 without
    x: f32, // 150, 0 to 1000 mm: of the target
    y: f32, // 900, 0 to 1000 mm: of the target
    radius: f32, // 50, 1 to 1000 mm: distance at which it is reached
}

struct TaskState {
    reached: u32,
}

// Distance that a wheel travels in a cycle at full speed, in sides of the maze.
const FARTHEST: f32 = 0.025f;

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let own = task_values(episode);
    if (own.goal == 0.0f) {
        let squared = squared_length(vec2<f32>(now.moved.left, now.moved.right));
        return Reward(-(FARTHEST * FARTHEST) * squared, before);
    }
    let distance = root(squared_length(vec2<f32>(now.end.x - own.x, now.end.y - own.y)));
    return Reward(-0.001f * distance, TaskState(select(0u, 1u, distance < own.radius)));
}

fn task_ends(episode: Episode, own: TaskState) -> bool {
    return own.reached != 0u;
}
