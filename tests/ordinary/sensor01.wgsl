// Compass: sine and cosine of the heading, plus eight-sector one-hot summary.
const TAU: f32 = 6.283185307;

struct SensorReadings {
  compass_cos: f32,
  compass_sin: f32,
  compass_sector: f32,
  compass_north: f32,
}

fn to_unit(x: f32) -> f32 {
  return x * 0.5 + 0.5;
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
  let turns = fract(pose.z);
  let angle = turns * TAU;
  let direction = vec2<f32>(cos(angle), sin(angle));

  var readings: SensorReadings;
  readings.compass_cos = to_unit(direction.x);
  readings.compass_sin = to_unit(direction.y);
  let sector = u32(turns * 8.0 + 0.5) % 8u;
  readings.compass_sector = f32(sector) / 7.0;
  let north = vec2<f32>(0.0, 1.0);
  readings.compass_north = pow(max(dot(direction, north), 0.0), 4.0);
  return Sensed(readings, before);
}
