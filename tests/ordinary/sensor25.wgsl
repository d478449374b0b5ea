// Floor texture: value noise from an integer hash, seen by two cells under
// the front of the robot.

const TAU = 6.2831853;
const GRAIN = 40.0;
const CELL_FORWARD = 30.0;
const CELL_SIDE = 12.0;

struct SensorReadings {
    floor_left: f32,
    floor_right: f32,
}

fn hash(p: vec2<i32>) -> f32 {
    var h = bitcast<u32>(p.x) * 374761393u + bitcast<u32>(p.y) * 668265263u;
    h = (h ^ (h >> 13u)) * 1274126177u;
    h ^= h >> 16u;
    return f32(h & 0xffffu) / 65535.0;
}

fn value_noise(p: vec2<f32>) -> f32 {
    let cell = floor(p);
    let f = fract(p);
    let u = f * f * (3.0 - 2.0 * f);
    let i = vec2<i32>(cell);
    let bottom = mix(hash(i), hash(i + vec2<i32>(1, 0)), u.x);
    let top = mix(hash(i + vec2<i32>(0, 1)), hash(i + vec2<i32>(1, 1)), u.x);
    return mix(bottom, top, u.y);
}

fn floor_at(p: vec2<f32>) -> f32 {
    var sum = 0.0;
    var amplitude = 0.5;
    var q = p / GRAIN;
    for (var octave = 0; octave < 3; octave++) {
        sum += amplitude * value_noise(q);
        q *= 2.03;
        amplitude *= 0.5;
    }
    return saturate(sum / 0.875);
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    let a = pose.z * TAU;
    let forward = vec2<f32>(cos(a), sin(a));
    let left = vec2<f32>(-forward.y, forward.x);
    let front = pose.xy + CELL_FORWARD * forward;
    let readings = SensorReadings(
        floor_at(front + CELL_SIDE * left),
        floor_at(front - CELL_SIDE * left));
    return Sensed(readings, before);
}
