// Energy: driving drains a battery, standing at the charger fills it.
// Reward is for speed while the battery lasts.

const CHARGER = vec2<f32>(150.0, 150.0);
const CHARGER_RADIUS = 120.0;
const IDLE_DRAIN = 0.0005;
const DRIVE_DRAIN = 0.004;
const CHARGE_RATE = 0.05;

struct TaskState {
    energy: f32,
    charging_cycles: u32,
    dead: u32,
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return TaskState(1.0, 0u, 0u);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var state = before;
    let effort = 0.5 * (abs(now.moved.left) + abs(now.moved.right));
    let near = distance(now.end.xy, CHARGER) < CHARGER_RADIUS;

    state.energy -= IDLE_DRAIN + DRIVE_DRAIN * effort * effort;
    if (near) {
        // Charging slows down as the battery gets full.
        state.energy += CHARGE_RATE * (1.0 - state.energy);
        state.charging_cycles += 1u;
    }
    state.energy = clamp(state.energy, 0.0, 1.0);
    state.dead |= u32(state.energy <= 0.0);

    let travelled = distance(now.start.xy, now.end.xy);
    let usable = smoothstep(0.0, 0.3, state.energy);
    let reward = select(travelled / 50.0 * usable, 0.0, near || now.collided);
    return Reward(reward, state);
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
    return bool(memory.dead);
}
