// Bearing to a beacon, as seen by the robot; blind when a wall is between.

const TWO_PI = 6.2831853;
const BEACON = vec2<f32>(500.0, 900.0);
const MOST = 1500.0;

struct SensorReadings {
    bearing_left: f32,
    bearing_right: f32,
    bearing_seen: f32,
}

struct SensorState {
    last_bearing: f32,
    unseen: u32,
}

fn wrap_turns(t: f32) -> f32 {
    return t - round(t);
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    let to = BEACON - pose.xy;
    let world = atan2(to.y, to.x) / TWO_PI;
    let free = distance_along(episode, pose.xy, world, MOST);
    let visible = free >= length(to) - 1.0;

    var state = before;
    if (visible) {
        state.last_bearing = wrap_turns(world - pose.z);
        state.unseen = 0u;
    } else {
        state.unseen += 1u;
    }

    // Confidence in a remembered bearing fades away.
    let trust = exp(-f32(state.unseen) / 20.0);
    let side = 2.0 * state.last_bearing * trust;
    let readings = SensorReadings(max(side, 0.0), max(-side, 0.0), f32(visible));
    return Sensed(readings, state);
}
