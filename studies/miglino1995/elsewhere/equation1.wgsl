// Equation 1 of Miglino, Lund and Nolfi (1995) as a robot can compute it alone: it does not know of collisions.
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let moved = now.moved;
    let speed = 0.5f * (abs(moved.left) + abs(moved.right));
    let straight = 1.0f - root(0.5f * abs(moved.left - moved.right));
    return Reward(speed * straight * (1.0f - highest(now.real)), before);
}
