// Straight, smooth, fast driving away from obstacles, after the
// classic navigation fitness V * (1 - sqrt(dv)) * (1 - i).

const RAYS = 8u;
const SENSE_RANGE = 150.0;

fn proximity(episode: Episode, pose: vec3<f32>) -> f32 {
    var nearest = SENSE_RANGE;
    for (var i = 0u; i < RAYS; i++) {
        let heading = pose.z + f32(i) / f32(RAYS);
        nearest = min(nearest, distance_along(episode, pose.xy, heading, SENSE_RANGE));
    }
    return 1.0 - nearest / SENSE_RANGE;
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let left = now.moved.left;
    let right = now.moved.right;

    let speed = 0.5 * (abs(left) + abs(right));
    let difference = abs(left - right) / 2.0;
    let i = proximity(episode, now.end);

    var reward = speed * (1.0 - sqrt(difference)) * (1.0 - i);
    if (left + right < 0.0) {
        reward *= 0.25; // backwards counts little
    }
    return Reward(reward, before);
}
