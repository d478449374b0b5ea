// A fan of rays in front, gathered into three sectors by their nearest hit.

const RAYS_PER_SECTOR = 5u;
const SECTORS = 3u;
const SPREAD = 0.4; // of a turn
const FAN_RANGE = 500.0;

struct SensorReadings {
    fan_right: f32,
    fan_front: f32,
    fan_left: f32,
    fan_openness: f32,
}

fn nearness(distance: f32) -> f32 {
    let x = 1.0 - clamp(distance / FAN_RANGE, 0.0, 1.0);
    return x * x;
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    const RAYS = RAYS_PER_SECTOR * SECTORS;
    var nearest = array<f32, SECTORS>(FAN_RANGE, FAN_RANGE, FAN_RANGE);
    var total = 0.0;

    for (var i = 0u; i < RAYS; i++) {
        let t = (f32(i) + 0.5) / f32(RAYS) - 0.5;
        let distance = distance_along(episode, pose.xy, pose.z + t * SPREAD, FAN_RANGE);
        let sector = i / RAYS_PER_SECTOR;
        nearest[sector] = min(nearest[sector], distance);
        total += distance;
    }

    let openness = total / (FAN_RANGE * f32(RAYS));
    return Sensed(
        SensorReadings(nearness(nearest[0]), nearness(nearest[1]), nearness(nearest[2]), saturate(openness)),
        before,
    );
}
