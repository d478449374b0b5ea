// Follow a speed profile given as a table over the episode, interpolated linearly.
const POINTS: u32 = 7u;
const TOP_SPEED: f32 = 20.0; // mm per cycle

struct TaskState {
    speed: f32,
    error: f32,
}

fn wanted_speed(t: f32) -> f32 {
    var table = array<f32, POINTS>(0.0, 0.4, 0.8, 1.0, 0.6, 0.6, 0.1);
    let x = clamp(t, 0.0, 1.0) * f32(POINTS - 1u);
    let index = min(u32(x), POINTS - 2u);
    return TOP_SPEED * mix(table[index], table[index + 1u], x - f32(index));
}

fn turn_difference(a: f32, b: f32) -> f32 {
    let d = (b - a + 1.5) % 1.0 - 0.5;
    return abs(d);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let t = f32(now.step) / f32(cycles(episode) - 1u);
    let measured = distance(now.end.xy, now.start.xy);
    let speed = mix(before.speed, measured, 0.25);
    let miss = (speed - wanted_speed(t)) / TOP_SPEED;
    var reward = exp(-8.0 * miss * miss);
    reward *= 1.0 - smoothstep(0.02, 0.1, turn_difference(now.start.z, now.end.z));
    reward *= f32(!now.collided);
    return Reward(reward, TaskState(speed, before.error + miss * miss));
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
    return memory.error > 100.0;
}
