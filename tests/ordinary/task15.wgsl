// Energy budget: motors drain a battery, a charging station fills it, driving earns reward.
const STATION = vec2<f32>(150.0, 150.0);
const STATION_RADIUS = 120.0;
const CHARGE_PER_CYCLE = 0.03;
const IDLE_COST = 0.0005;
const MOTOR_COST = 0.004;
const COLLISION_COST = 0.02;

struct TaskState {
    energy: f32,
    travelled: f32,
    charges: i32,
    at_station: u32,
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    var world: TaskState;
    world.energy = 1.0;
    world.at_station = u32(distance(pose.xy, STATION) < STATION_RADIUS);
    return world;
}

fn motor_cost(moved: Motion) -> f32 {
    let effort = vec2<f32>(moved.left, moved.right);
    return IDLE_COST + MOTOR_COST * dot(effort, effort) / 2.0;
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var next = before;
    next.energy -= motor_cost(now.moved);
    if now.collided {
        next.energy -= COLLISION_COST;
    }
    let inside = distance(now.end.xy, STATION) < STATION_RADIUS;
    if (inside) {
        next.energy += CHARGE_PER_CYCLE;
        if (!bool(before.at_station)) {
            next.charges += 1;
        }
    }
    next.at_station = select(0u, 1u, inside);
    next.energy = clamp(next.energy, 0.0, 1.0);
    let covered = length(now.end.xy - now.start.xy);
    next.travelled += covered;
    let reward = select(covered / 50.0, 0.0, inside) * sqrt(next.energy);
    return Reward(reward, next);
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
    return memory.energy <= 0.0 || memory.charges > 20;
}
