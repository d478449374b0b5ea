// Phototaxis: a lamp at a fixed place; reward for being in its light and for coming closer.
const LAMP = vec2<f32>(400.0, 300.0);
const LAMP_RADIUS: f32 = 150.0;

fn brightness(position: vec2<f32>) -> f32 {
    let d = distance(position, LAMP) / LAMP_RADIUS;
    return 1.0 / (1.0 + d * d);
}

fn facing(pose: vec3<f32>) -> f32 {
    let angle = pose.z * 6.2831853;
    let forward = vec2<f32>(cos(angle), sin(angle));
    let to_lamp = LAMP - pose.xy;
    if (length(to_lamp) < 1.0) {
        return 1.0;
    }
    return max(0.0, dot(forward, normalize(to_lamp)));
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let gain = brightness(now.end.xy) - brightness(now.start.xy);
    var reward = 0.7 * brightness(now.end.xy) + 0.2 * facing(now.end) + 5.0 * gain;
    if (now.collided) {
        reward *= 0.5;
    }
    return Reward(reward, before);
}
