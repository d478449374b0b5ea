// Visit waypoints in order. Progress towards the current one is rewarded,
// and arriving gives a bonus.

const WAYPOINTS = 5u;
const ARRIVAL_RADIUS = 60.0;

struct TaskState {
    next: u32,
    laps: u32,
    distance: f32,
}

fn waypoint(index: u32) -> vec2<f32> {
    var points = array<vec2<f32>, 5>(
        vec2<f32>(200.0, 200.0),
        vec2<f32>(800.0, 250.0),
        vec2<f32>(750.0, 800.0),
        vec2<f32>(450.0, 550.0),
        vec2<f32>(180.0, 820.0),
    );
    return points[index % WAYPOINTS];
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return TaskState(0u, 0u, distance(pose.xy, waypoint(0u)));
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var state = before;
    let here = now.end.xy;
    let distance_now = length(waypoint(state.next) - here);

    var reward = (state.distance - distance_now) / 100.0;
    state.distance = distance_now;

    if (distance_now < ARRIVAL_RADIUS) {
        reward += 5.0;
        state.next += 1u;
        if (state.next == WAYPOINTS) {
            state.next = 0u;
            state.laps++;
            reward += 10.0;
        }
        state.distance = length(waypoint(state.next) - here);
    }

    reward -= select(0.0, 0.2, now.collided);
    return Reward(reward, state);
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
    return memory.laps >= 3u;
}
