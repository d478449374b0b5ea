// Gradient: an odour field of three sources, its strength and slope in the robot frame.
const SOURCES = 3u;
const sources = array<vec3<f32>, SOURCES>(
  vec3<f32>(300.0, 400.0, 1.0),
  vec3<f32>(-500.0, 100.0, 0.7),
  vec3<f32>(100.0, -600.0, 0.4),
);

struct SensorReadings {
  odour_strength: f32,
  odour_ahead: f32,
  odour_aside: f32,
  odour_rising: f32,
}

struct SensorState {
  previous: f32,
}

fn field(p: vec2<f32>) -> f32 {
  var sum = 0.0;
  for (var i = 0u; i < SOURCES; i++) {
    let d = distance(p, sources[i].xy) / 300.0;
    sum += sources[i].z * exp(-d * d);
  }
  return sum;
}

fn gradient(p: vec2<f32>) -> vec2<f32> {
  let h = 5.0;
  let dx = field(p + vec2<f32>(h, 0.0)) - field(p - vec2<f32>(h, 0.0));
  let dy = field(p + vec2<f32>(0.0, h)) - field(p - vec2<f32>(0.0, h));
  return vec2<f32>(dx, dy) / (2.0 * h);
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
  let g = gradient(pose.xy);
  let a = radians(pose.z * 360.0);
  let ahead = vec2<f32>(cos(a), sin(a));
  let n = select(vec2<f32>(0.0), normalize(g), length(g) > 1e-7);
  let strength = field(pose.xy);
  let rising = step > 0u && strength > before.previous;
  return Sensed(SensorReadings(saturate(strength), 0.5 + 0.5 * dot(n, ahead),
    0.5 + 0.5 * dot(n, vec2<f32>(-ahead.y, ahead.x)), f32(rising)), SensorState(strength));
}
