// Docking: come into the station slowly and with the right heading.

const TAU = 6.2831853;
const DOCK = vec3<f32>(900.0, 500.0, 0.0);
const PHASE_APPROACH = 0u;
const PHASE_ALIGN = 1u;
const PHASE_DOCKED = 2u;

struct TaskState {
    phase: u32,
    held: u32,
}

fn alignment(heading: f32) -> f32 {
    return 0.5 * (1.0 + cos((heading - DOCK.z) * TAU));
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var state = before;
    let distance = length(now.end.xy - DOCK.xy);
    let closing = length(now.start.xy - DOCK.xy) - distance;
    let facing = alignment(now.end.z);
    let speed = abs(now.moved.left + now.moved.right) / 2.0;
    var reward = 0.0;

    switch (state.phase) {
        case PHASE_APPROACH: {
            reward = closing / 20.0;
            if (distance < 200.0) {
                state.phase = PHASE_ALIGN;
            }
        }
        case PHASE_ALIGN: {
            reward = closing / 20.0 * facing - 0.1 * speed * f32(distance < 80.0);
            if (distance < 30.0 && facing > 0.95) {
                state.phase = PHASE_DOCKED;
                reward += 5.0;
            } else if (distance > 260.0) {
                state.phase = PHASE_APPROACH;
                reward -= 1.0;
            }
        }
        default: {
            state.held += 1u;
            reward = 1.0 - speed;
        }
    }
    return Reward(reward, state);
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
    return memory.held > 40u;
}
