// Wall following: keep a wall on the right at a given distance and move on.
const WANTED: f32 = 150.0;
const TOLERANCE: f32 = 60.0;
const MOST: f32 = 800.0;

fn gaussian(x: f32, sigma: f32) -> f32 {
  let t = x / sigma;
  return exp(-0.5 * t * t);
}

fn forward_progress(start: vec3<f32>, end: vec3<f32>) -> f32 {
  let angle = start.z * 6.2831853;
  let ahead = vec2<f32>(cos(angle), sin(angle));
  return dot(end.xy - start.xy, ahead);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
  var nearest = MOST;
  for (var i = -1; i <= 1; i++) {
    let heading = fract(now.end.z - 0.25 + f32(i) * 0.05);
    nearest = min(nearest, distance_along(episode, now.end.xy, heading, MOST));
  }
  let front = distance_along(episode, now.end.xy, now.end.z, MOST);
  let keep = gaussian(nearest - WANTED, TOLERANCE);
  let advance = clamp(forward_progress(now.start, now.end) / 20.0, -1.0, 1.0);
  let blocked = 1.0 - smoothstep(80.0, 250.0, front);

  var reward = keep * advance - 0.3 * blocked;
  if now.collided {
    reward = -1.0;
  }
  return Reward(reward, before);
}
