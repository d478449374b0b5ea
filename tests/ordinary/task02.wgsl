// Visit five waypoints in order.
const COUNT = 5u;
const REACH = 120.0;

struct TaskState {
  next: u32,
  distance: f32,
};

fn waypoint(i: u32) -> vec2f {
  var points = array<vec2f, COUNT>(
    vec2f(600.0, 0.0),
    vec2f(600.0, 600.0),
    vec2f(-300.0, 600.0),
    vec2f(-600.0, -200.0),
    vec2f(0.0, 0.0)
  );
  return points[min(i, COUNT - 1u)];
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
  return TaskState(0u, distance(pose.xy, waypoint(0u)));
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
  var after = before;
  let goal = waypoint(before.next);
  let d = length(goal - now.end.xy);
  var reward = (before.distance - d) / 100.0;
  after.distance = d;
  if (d < REACH) {
    reward += 5.0;
    after.next += 1u;
    after.distance = length(waypoint(after.next) - now.end.xy);
  }
  reward -= select(0.0, 0.5, now.collided);
  return Reward(reward, after);
}

fn task_ends(episode: Episode, memory: TaskState) -> bool {
  return memory.next >= COUNT;
}
