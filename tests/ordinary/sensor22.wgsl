// Range to two radio beacons by their strength, with multiplicative noise.

const BEACONS = 2;
const REFERENCE = 100.0;
const EXPONENT = 1.8;

struct SensorReadings {
    beacon_a_strength: f32,
    beacon_b_strength: f32,
    beacon_contrast: f32,
}

fn beacon(index: i32) -> vec2<f32> {
    var places = array<vec2<f32>, BEACONS>(vec2<f32>(0.0, 1000.0), vec2<f32>(1000.0, 0.0));
    return places[index];
}

fn strength(p: vec2<f32>, index: i32) -> f32 {
    let distance = distance(p, beacon(index));
    return 1.0 / (1.0 + pow(distance / REFERENCE, EXPONENT));
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    let noise = random(episode, STREAM_OWN_SENSOR, step, 0u);
    let fade = 0.9 + 0.2 * noise.xy;
    var s: vec2<f32>;
    for (var i = 0; i < BEACONS; i++) {
        s[i] = saturate(sqrt(strength(pose.xy, i)) * fade[i]);
    }
    let contrast = (s.x - s.y) / max(s.x + s.y, 0.001);
    return Sensed(SensorReadings(s.x, s.y, 0.5 + 0.5 * contrast), before);
}
