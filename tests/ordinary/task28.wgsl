// Corridor: drive along it, keep to its middle, do not touch the walls.

const LOOK = 600.0;
const MAX_SPEED = 12.0; // mm per cycle

struct TaskState {
    collisions: u32,
    furthest: f32,
    origin: vec2<f32>,
}

fn centring(episode: Episode, pose: vec3<f32>) -> f32 {
    let left = distance_along(episode, pose.xy, pose.z + 0.25, LOOK);
    let right = distance_along(episode, pose.xy, pose.z - 0.25, LOOK);
    let width = max(left + right, 1.0);
    return 1.0 - abs(left - right) / width;
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    var state: TaskState;
    state.origin = pose.xy;
    return state;
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var state = before;
    let offset = now.end.xy - state.origin;
    let distance = length(offset);
    let gained = max(distance - state.furthest, 0.0);
    state.furthest = max(state.furthest, distance);

    let middle = centring(episode, now.end);
    var reward = gained / MAX_SPEED * pow(middle, 2.0);

    if (now.collided) {
        state.collisions += 1u;
        reward -= 0.1 * f32(min(state.collisions, 10u));
    }
    return Reward(reward, state);
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
    return memory.collisions > 25u;
}
