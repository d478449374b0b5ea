// A robot on two wheels that lag behind their commands, are not quite equal, and slip when the body is stopped.
// A cycle of 100 ms is five steps of 20 ms.

const SUBSTEPS: u32 = 5u;
const SUBSTEP: f32 = 0.02f;

// Where a cycle leads: the pose (mm and turns, the heading not yet reduced), and the wheels' speeds then, mm/s.
struct Ridden {
    x: f32,
    y: f32,
    heading: f32,
    left: f32,
    right: f32,
}

// A cycle's ride. A robot that `minds` objects stops before them and slides along; one that does not goes through.
fn ride(world: u32, start: Ridden, moved: Motion, minds: bool) -> Ridden {
    let wheels = wheels_of(world);
    let arc = timing_of(world).arc;
    let goal_left = moved.left * wheels.full_left;
    let goal_right = moved.right * wheels.full_right;
    var robot = start;
    for (var substep = 0u; substep < SUBSTEPS; substep++) {
        robot.left += wheels.response * (goal_left - robot.left);
        robot.right += wheels.response * (goal_right - robot.right);
        let turn = (robot.right - robot.left) * (SUBSTEP * wheels.turns_per_mm);
        let ahead = cosine_sine(start.heading + arc * (robot.heading + 0.5f * turn - start.heading));
        let length = (0.5f * SUBSTEP) * (robot.left + robot.right);
        var next = vec2<f32>(robot.x + length * ahead.x, robot.y + length * ahead.y);
        if (minds) {
            next = slid(world, vec2<f32>(robot.x, robot.y), next, false);
        }
        robot.x = next.x;
        robot.y = next.y;
        robot.heading += turn;
    }
    return robot;
}

// What a cycle does to a robot, and whether it ends in a collision: if its ride would end where it touches an
// object. It then does, of what a sliding robot does, the fraction that its wheels slip, or nothing.
struct Reached {
    pose: vec3<f32>,
    left: f32,
    right: f32,
    collided: bool,
}

fn reached(world: u32, pose: vec3<f32>, speeds: vec2<f32>, moved: Motion) -> Reached {
    let start = Ridden(pose.x, pose.y, pose.z, speeds.x, speeds.y);
    var end = start;
    var held = start;
    var collided = false;
    // First as if nothing stood in the way; then, if that ends where something stands, once more.
    for (var attempt = 0u; attempt < 2u; attempt++) {
        let minds = attempt == 1u;
        if (!minds | collided) {
            let ridden = ride(world, start, moved, minds);
            if (minds) {
                held = ridden;
            } else {
                end = ridden;
                collided = touches(world, vec2<f32>(end.x, end.y));
            }
        }
    }
    if (collided) {
        let slip = timing_of(world).slip;
        let at = vec2<f32>(pose.x + slip * (held.x - pose.x), pose.y + slip * (held.y - pose.y));
        let stuck = touches(world, at);
        end = Ridden(
            select(at.x, pose.x, stuck), select(at.y, pose.y, stuck),
            pose.z + slip * (held.heading - pose.z), 0.0f, 0.0f,
        );
    }
    return Reached(vec3<f32>(end.x, end.y, end.heading), end.left, end.right, collided);
}
