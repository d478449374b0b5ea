// Polar grid: occupancy of near and far rings in four directions, plus place coding.
const TAU = 6.2831853;
const NEAR = 200.0;
const FAR = 600.0;

struct SensorReadings {
  polar_near_front: f32,
  polar_near_left: f32,
  polar_near_back: f32,
  polar_near_right: f32,
  polar_far_front: f32,
  polar_far_left: f32,
  polar_far_back: f32,
  polar_far_right: f32,
  polar_ring: f32,
  polar_sector: f32,
}

fn ring(d: f32, inner: f32, outer: f32) -> f32 {
  return select(0.0, 1.0, d >= inner && d < outer);
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
  var near: vec4<f32>;
  var far = vec4<f32>();
  for (var k = 0; k < 4; k++) {
    for (var j = -1; j <= 1; j++) {
      let heading = fract(pose.z + f32(k) / 4.0 + f32(j) * 0.06);
      let d = distance_along(episode, pose.xy, heading, FAR);
      near[k] += ring(d, 0.0, NEAR) / 3.0;
      far[k] += ring(d, NEAR, FAR) / 3.0;
    }
  }
  near = clamp(near, vec4<f32>(0.0), vec4<f32>(1.0));
  far = clamp(far, vec4<f32>(0.0), vec4<f32>(1.0));

  let radius = length(pose.xy);
  let theta = fract(atan2(pose.y, pose.x) / TAU + 1.0);
  let index = i32(radius / 250.0);
  let ring_code = f32(clamp(index, 0, 4)) / 4.0;
  let sector_code = floor(theta * 12.0) / 12.0;
  return Sensed(SensorReadings(near.x, near.y, near.z, near.w,
    far.x, far.y, far.z, far.w, ring_code, sector_code), before);
}
