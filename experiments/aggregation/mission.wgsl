// Aggregation, as Gauci, Chen, Li, Dodd and Gross (2014) measure it: once a second, the time in seconds times the dispersion, the
// sum of squared distances from the swarm's centre over four squared radii. What is summed is minimised, so that its negative is the
// fitness.
struct MissionState {
    dispersion: f32,
    // clusters, whose robots are linked by less than a body's diameter between two bodies, and the robots in the largest
    clusters: u32,
    largest: u32,
    // when all robots were first in one cluster, s; -1 if they never were
    together_s: f32,
}

fn mission_begin(episode: Episode) -> MissionState {
    return MissionState(0.0f, 0u, 0u, -1.0f);
}

fn dispersion(episode: Episode) -> f32 {
    let count = robots(episode);
    let share = reciprocal(f32(count));
    var centre = vec2<f32>(0.0f, 0.0f);
    for (var robot = 0u; robot < count; robot++) {
        let pose = robot_pose(episode, robot);
        centre += vec2<f32>(pose.x, pose.y);
    }
    centre = share * centre;
    var sum = 0.0f;
    for (var robot = 0u; robot < count; robot++) {
        let pose = robot_pose(episode, robot);
        sum += squared_length(vec2<f32>(pose.x - centre.x, pose.y - centre.y));
    }
    let body = body_radius(episode);
    return sum * reciprocal(4.0f * body * body);
}

fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    if (step % 10u != 9u) {
        return Tally(0.0f, before);
    }
    let time = 0.1f * f32(step + 1u);
    let found = clusters_within(episode, 4.0f * body_radius(episode));
    var now = MissionState(dispersion(episode), found.count, found.largest, before.together_s);
    if ((found.count == 1u) & (now.together_s < 0.0f)) {
        now.together_s = time;
    }
    return Tally(-time * now.dispersion, now);
}
