// Zones on the floor, each with its own reward from a table.

const COLUMNS = 4;
const ROWS = 4;
const ZONE_SIZE = 250.0;

const ZONE_REWARD = array<f32, 16>(
     0.0,  0.1,  0.1,  0.5,
    -0.2,  0.0,  0.0,  0.1,
    -0.2, -1.0,  0.0,  0.1,
     1.0, -0.2,  0.0,  0.0,
);

struct TaskState {
    zone: i32,
    stay: i32,
}

fn zone_at(p: vec2<f32>) -> i32 {
    let x = clamp(i32(p.x / ZONE_SIZE), 0, COLUMNS - 1);
    let y = clamp(i32(p.y / ZONE_SIZE), 0, ROWS - 1);
    return y * COLUMNS + x;
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return TaskState(zone_at(pose.xy), 0);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let zone = zone_at(now.end.xy);
    let stay = select(0, before.stay + 1, zone == before.zone);

    // Positive zones wear off while the robot sits in them.
    var reward = ZONE_REWARD[zone];
    if (reward > 0.0) {
        reward *= pow(0.98, f32(stay));
    }
    if (zone != before.zone) {
        reward += 0.05;
    }
    return Reward(reward, TaskState(zone, stay));
}
