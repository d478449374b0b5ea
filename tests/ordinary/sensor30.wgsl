// A sonar on a turret: it sweeps over five directions, one each cycle, with
// a cone of rays, dropouts, and the last echo of each direction kept.

const DIRECTIONS = 5u;
const CONE = 7;
const CONE_WIDTH = 0.06;
const SONAR_RANGE = 800.0;
const DROPOUT = 0.05;

struct SensorReadings {
    sonar_hard_right: f32,
    sonar_right: f32,
    sonar_ahead: f32,
    sonar_left: f32,
    sonar_hard_left: f32,
}

struct SensorState {
    echoes: vec4<f32>,
    last_echo: f32,
}

fn ping(episode: Episode, pose: vec3<f32>, direction: f32) -> f32 {
    var nearest = SONAR_RANGE;
    for (var i = 0; i < CONE; i++) {
        let offset = (f32(i) / f32(CONE - 1) - 0.5) * CONE_WIDTH;
        // Rays on the rim of the cone echo less and look further away.
        let rim = 1.0 + 8.0 * abs(offset) * abs(offset) / (CONE_WIDTH * CONE_WIDTH);
        let echo = distance_along(episode, pose.xy, pose.z + direction + offset, SONAR_RANGE);
        nearest = min(nearest, echo * rim);
    }
    return nearest / SONAR_RANGE;
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    var echoes = array<f32, DIRECTIONS>(
        before.echoes.x, before.echoes.y, before.echoes.z, before.echoes.w, before.last_echo);

    let index = step % DIRECTIONS;
    let direction = (f32(index) - 2.0) * 0.125;
    let r = random(episode, STREAM_OWN_SENSOR, step, 0u);
    if (r.x >= DROPOUT) {
        let noisy = ping(episode, pose, direction) + 0.02 * (r.y - 0.5);
        echoes[index] = 1.0 - saturate(noisy);
    } else {
        echoes[index] *= 0.5;
    }

    let readings = SensorReadings(echoes[0], echoes[1], echoes[2], echoes[3], echoes[4]);
    return Sensed(readings, SensorState(vec4<f32>(echoes[0], echoes[1], echoes[2], echoes[3]), echoes[4]));
}
