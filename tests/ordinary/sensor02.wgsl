// Range and bearing to a beacon, with occlusion by walls.
const BEACON = vec2f(400.0, -250.0);
const RANGE = 1500.0;
const TAU = 6.2831853;

struct SensorReadings {
  beacon_range: f32,
  beacon_left: f32,
  beacon_right: f32,
  beacon_seen: f32,
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3f, before: SensorState) -> Sensed {
  let offset = BEACON - pose.xy;
  let d = length(offset);
  let world = atan2(offset.y, offset.x) / TAU;
  var relative = fract(world - pose.z);
  if (relative > 0.5) {
    relative -= 1.0;
  }
  let free = distance_along(episode, pose.xy, fract(world), RANGE);
  let seen = d < RANGE && free >= d - 1.0;

  var out: SensorReadings;
  if (seen) {
    out.beacon_range = 1.0 - clamp(d / RANGE, 0.0, 1.0);
    out.beacon_left = clamp(relative * 2.0, 0.0, 1.0);
    out.beacon_right = clamp(-relative * 2.0, 0.0, 1.0);
  }
  out.beacon_seen = f32(seen);
  return Sensed(out, before);
}
