// Hash noise: a fixed "floor texture" from value noise, like a reflectance sensor.
struct SensorReadings {
  floor_left: f32,
  floor_right: f32,
  floor_contrast: f32,
}

fn hash(p: vec2<i32>) -> f32 {
  var h = bitcast<u32>(p.x) * 374761393u + bitcast<u32>(p.y) * 668265263u;
  h = (h ^ (h >> 13u)) * 1274126177u;
  h ^= h >> 16u;
  return f32(h & 0xffffu) / 65535.0;
}

fn value_noise(p: vec2<f32>) -> f32 {
  let cell = floor(p);
  let i = vec2<i32>(cell);
  var f = p - cell;
  f = f * f * (3.0 - 2.0 * f);
  let bottom = mix(hash(i), hash(i + vec2<i32>(1, 0)), f.x);
  let top = mix(hash(i + vec2<i32>(0, 1)), hash(i + vec2<i32>(1, 1)), f.x);
  return mix(bottom, top, f.y);
}

fn fbm(p: vec2<f32>) -> f32 {
  var sum = 0.0;
  var amplitude = 0.5;
  var q = p;
  for (var octave = 0u; octave < 4u; octave++) {
    sum += amplitude * value_noise(q);
    q *= 2.0;
    amplitude *= 0.5;
  }
  return sum / 0.9375;
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
  let angle = pose.z * 6.2831853;
  let side = 30.0 * vec2<f32>(-sin(angle), cos(angle));
  let l = fbm((pose.xy + side) / 200.0);
  let r = fbm((pose.xy - side) / 200.0);
  return Sensed(SensorReadings(l, r, saturate(abs(l - r) * 4.0)), before);
}
