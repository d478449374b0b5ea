// Wall following: keep the wall on the right at a set distance and move on.

const DESIRED = 80.0;
const TOLERANCE = 35.0;
const MOST = 400.0;
const TURN_RIGHT = -0.25;

struct TaskState {
    mean_error: f32,
    streak: u32,
}

fn wall_distance(episode: Episode, pose: vec3<f32>) -> f32 {
    let side = distance_along(episode, pose.xy, pose.z + TURN_RIGHT, MOST);
    let ahead = distance_along(episode, pose.xy, pose.z + TURN_RIGHT / 2, MOST);
    // The diagonal ray, projected on the side.
    return min(side, ahead * sqrt(0.5));
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var state = before;
    let error = (wall_distance(episode, now.end) - DESIRED) / TOLERANCE;
    let closeness = exp(-error * error);

    let angle = now.end.z * 6.2831853;
    let forward = vec2<f32>(cos(angle), sin(angle));
    let progress = dot(now.end.xy - now.start.xy, forward);

    state.mean_error = mix(state.mean_error, abs(error), 0.05);
    if (abs(error) < 1.0 && !now.collided) {
        state.streak += 1u;
    } else {
        state.streak = 0u;
    }

    let bonus = 1.0 + min(f32(state.streak) / 100.0, 1.0);
    var reward = closeness * max(progress, 0.0) * 0.1 * bonus;
    reward /= 1.0 + state.mean_error;
    return Reward(reward, state);
}
