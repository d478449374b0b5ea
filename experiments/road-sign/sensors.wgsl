// Two light sensors, at the left and at the right of the robot, that see the lamp in the stem's wall only from nearby.

struct SensorValues {
    reach: f32, // 100, 1 to 1000 mm: from which the lamp is seen
    noise: f32, // 0.05, 0 to 1: greatest error of a reading
}

struct SensorReadings {
    light_left: f32,
    light_right: f32,
}

// The walls of the stem, and where lamps are in them, mm.
const LEFT_WALL: f32 = 300.0f;
const RIGHT_WALL: f32 = 430.0f;
const NEAREST_LAMP: f32 = 190.0f;
const SPAN_OF_LAMPS: f32 = 100.0f;

// The lamp of an episode.
fn lamp(episode: Episode) -> vec2<f32> {
    let drawn = random(episode, STREAM_TASK, 0u, 0u);
    return vec2<f32>(select(RIGHT_WALL, LEFT_WALL, drawn.x < 0.5f), NEAREST_LAMP + SPAN_OF_LAMPS * drawn.y);
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    let own = sensor_values(episode);
    let to = lamp(episode) - vec2<f32>(pose.x, pose.y);
    let ahead = cosine_sine(pose.z);
    let is_left = ahead.x * to.y - ahead.y * to.x > 0.0f;
    let is_seen = squared_length(to) < own.reach * own.reach;
    let errors = random(episode, STREAM_OWN_SENSOR, step, 0u);
    let left = select(0.0f, 1.0f, is_seen & is_left) + own.noise * (2.0f * errors.x - 1.0f);
    let right = select(0.0f, 1.0f, is_seen & !is_left) + own.noise * (2.0f * errors.y - 1.0f);
    return Sensed(SensorReadings(left, right), before);
}
