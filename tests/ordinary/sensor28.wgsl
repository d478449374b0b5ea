// Colour of the floor: a chequered field with a black ring and a bright spot.

const TILE = 100.0;
const RING_CENTRE = vec2<f32>(600.0, 400.0);
const RING = vec2<f32>(150.0, 180.0);
const SPOT = vec2<f32>(200.0, 800.0);

struct SensorReadings {
    ground_grey: f32,
    ground_ring: f32,
    ground_edge: f32,
}

struct SensorState {
    grey: f32,
}

fn chequer(p: vec2<f32>) -> f32 {
    let tile = vec2<i32>(floor(p / TILE));
    let odd = ((tile.x + tile.y) & 1) == 1;
    return select(0.35, 0.65, odd);
}

fn in_ring(p: vec2<f32>) -> bool {
    let r = distance(p, RING_CENTRE);
    return r > RING.x && r < RING.y;
}

fn grey_at(p: vec2<f32>) -> f32 {
    if (in_ring(p)) {
        return 0.0;
    }
    let glow = 1.0 - smoothstep(0.0, 120.0, distance(p, SPOT));
    return mix(chequer(p), 1.0, glow);
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    let noise = random(episode, STREAM_OWN_SENSOR, step, 0u).x - 0.5;
    let grey = clamp(grey_at(pose.xy) + 0.04 * noise, 0.0, 1.0);
    let edge = select(abs(grey - before.grey), 0.0, step == 0u);
    return Sensed(SensorReadings(grey, f32(in_ring(pose.xy)), edge), SensorState(grey));
}
