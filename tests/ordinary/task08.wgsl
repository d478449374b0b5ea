// Zone rewards: the arena is cut into 4 x 4 zones, each with its own pay.
const ZONES: u32 = 4u;
const SIZE: f32 = 400.0;

const PAY = array<f32, 16>(
  -0.5, 0.0, 0.0, 0.2,
  0.0, 0.1, 0.3, 0.0,
  0.0, 0.3, 1.0, -0.2,
  0.2, 0.0, -0.2, 0.5
);

struct TaskState {
  zone: u32,
  dwell: u32,
}

fn zone_of(p: vec2<f32>) -> u32 {
  let half_width = 0.5 * SIZE * f32(ZONES);
  let q = clamp((p + half_width) / SIZE, vec2<f32>(0.0), vec2<f32>(f32(ZONES) - 0.001));
  let cell = vec2<u32>(q);
  return cell.y * ZONES + cell.x;
}

fn pay_at(zone: u32) -> f32 {
  var table = PAY;
  return table[zone % 16u];
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
  return TaskState(zone_of(pose.xy), 0u);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
  let zone = zone_of(now.end.xy);
  var dwell = before.dwell + 1u;
  if (zone != before.zone) {
    dwell = 0u;
  }
  // staying too long makes a zone boring
  let fade = exp(-f32(dwell) / 100.0);
  let pay = pay_at(zone);
  var reward = pay;
  if (pay > 0.0) {
    reward *= fade;
  }
  reward -= 0.25 * f32(now.collided);
  return Reward(reward, TaskState(zone, dwell));
}
