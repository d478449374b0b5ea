// Ray fan: five proximity rays across the front.
const RAYS = 5;
const SPREAD = 0.3;
const REACH = 500.0;

struct SensorReadings {
  fan_far_left: f32,
  fan_left: f32,
  fan_front: f32,
  fan_right: f32,
  fan_far_right: f32,
}

fn proximity(d: f32) -> f32 {
  let x = 1.0 - clamp(d / REACH, 0.0, 1.0);
  return x * x;
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
  var rays: array<f32, RAYS>;
  for (var i = 0; i < RAYS; i++) {
    let t = f32(i) / f32(RAYS - 1) - 0.5;
    let heading = fract(pose.z - t * SPREAD);
    rays[i] = proximity(distance_along(episode, pose.xy, heading, REACH));
  }
  let noise = random(episode, STREAM_OWN_SENSOR, step, 0u);
  rays[2] = clamp(rays[2] + (noise.x - 0.5) * 0.02, 0.0, 1.0);
  let readings = SensorReadings(rays[0], rays[1], rays[2], rays[3], rays[4]);
  return Sensed(readings, before);
}
