// Corridor: follow a bent corridor given by its centre line.
const LINE_POINTS = 5;
const HALF_WIDTH = 140.0;

struct TaskState {
  progress: f32,
  outside: u32,
}

struct Projection {
  along: f32,
  off: f32,
}

fn project(p: vec2<f32>) -> Projection {
  var line = array<vec2<f32>, 5>(
    vec2<f32>(-800.0, -400.0), vec2<f32>(-200.0, -400.0), vec2<f32>(0.0, 0.0),
    vec2<f32>(300.0, 300.0), vec2<f32>(800.0, 300.0));
  var best = Projection(0.0, 1e9);
  var walked = 0.0;
  for (var i = 0; i < LINE_POINTS - 1; i++) {
    let a = line[i];
    let b = line[i + 1];
    let ab = b - a;
    let len = length(ab);
    let t = clamp(dot(p - a, ab) / (len * len), 0.0, 1.0);
    let off = distance(p, a + ab * t);
    if (off < best.off) {
      best = Projection(walked + t * len, off);
    }
    walked += len;
  }
  return best;
}

fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
  return TaskState(project(pose.xy).along, 0u);
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
  let here = project(now.end.xy);
  let inside = here.off <= HALF_WIDTH;
  var reward = (here.along - before.progress) / 50.0;
  if (!inside) {
    reward -= 0.2 + (here.off - HALF_WIDTH) / 500.0;
  }
  return Reward(reward, TaskState(here.along, select(before.outside + 1u, 0u, inside)));
}

fn task_ends(episode: Episode, memory: TaskState) -> bool { return memory.outside > 200u; }
