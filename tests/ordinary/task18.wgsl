// Stay near the nearest of several beacons, whose places are drawn anew for every episode.
const BEACONS: u32 = 6u;
const ARENA: f32 = 1000.0;

struct Nearest {
    index: u32,
    distance: f32,
}

struct TaskState {
    current: u32,
    dwell: u32,
    best: f32,
}

fn beacon(episode: Episode, index: u32) -> vec2<f32> {
    return ARENA * random(episode, STREAM_TASK, 0u, index).xy;
}

fn nearest_beacon(episode: Episode, position: vec2<f32>) -> Nearest {
    var result = Nearest(0u, 1e10);
    for (var i = 0u; i < BEACONS; i++) {
        let d = length(beacon(episode, i) - position);
        if (d < result.distance) {
            result.index = i;
            result.distance = d;
        }
    }
    return result;
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    let nearest = nearest_beacon(episode, pose.xy);
    return TaskState(nearest.index, 0u, nearest.distance);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let nearest = nearest_beacon(episode, now.end.xy);
    var state = before;
    if (nearest.index == before.current) {
        state.dwell++;
    } else {
        state.current = nearest.index;
        state.dwell = 0u;
    }
    state.best = min(state.best, nearest.distance);
    let boredom = exp(-f32(state.dwell) / 50.0);
    let closeness = 1.0 - smoothstep(30.0, 250.0, nearest.distance);
    let penalty = select(0.0, 0.2, now.collided);
    return Reward(closeness * boredom - penalty, state);
}
