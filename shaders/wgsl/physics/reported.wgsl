// Episode of a robot outside the kernel: its readings and poses are reported, cycle by cycle, before an episode's
// genes. The controller decides, and the task rewards, as in the simulator.

// What an episode keeps from one dispatch to the next, and its fitness so far.
struct EpisodeState {
    task: TaskState,
    controller: ControllerState,
    sensor: SensorState,
    x: f32,
    y: f32,
    heading: f32,
    fitness: f32,
    robot: RobotState,
}

// A cycle's motion, and what the robot remembers after it.
struct Driven {
    motion: Motion,
    state: RobotState,
}

fn report(episode: Episode, index: u32) -> f32 {
    return bitcast<f32>(inputs[episode.genes + index * LANES]);
}

// A pose, of which the first number is given.
fn reported_pose(episode: Episode, first: u32) -> vec3<f32> {
    return vec3<f32>(report(episode, first), report(episode, first + 1u), report(episode, first + 2u));
}

// The episode as the controller knows it: its genes are after the reports.
fn of_genes(episode: Episode) -> Episode {
    return Episode(episode.world, episode.key, episode.genes + REPORTS * LANES, episode.trial);
}

fn first_state(episode: Episode) -> EpisodeState {
    let pose = reported_pose(episode, REPORTED_START);
    let me = of_genes(episode);
    return EpisodeState(
        task_begin(me, pose), controller_begin(me), sensor_begin(me, pose),
        pose.x, pose.y, pose.z, 0.0f, RobotState(),
    );
}

fn kept(after: EpisodeState) -> EpisodeState {
    return EpisodeState(
        task_kept(after.task), controller_kept(after.controller), sensor_kept(after.sensor),
        stored(after.x), stored(after.y), stored(after.heading), stored(after.fitness), robot_kept(after.robot),
    );
}

fn cycle(episode: Episode, step: u32, before: EpisodeState) -> Cycle {
    let me = of_genes(episode);
    var after = before;
    let pose = vec3<f32>(after.x, after.y, after.heading);
    let sensed = sensors_read(me, step, pose, after.sensor);
    after.sensor = sensed.state;
    var readings = reported_readings(episode);
    readings.own = sensed.readings;
    let command = commands(me, step, readings, after.controller);
    after.controller = command.state;
    let driven = motion(me, step, command.outputs, after.robot);
    after.robot = driven.state;
    let end = reported_pose(episode, REPORTED_END);
    after.x = end.x;
    after.y = end.y;
    after.heading = end.z;
    after.robot = robot_after(episode.world, end, after.robot);
    let now = Experience(step, pose, end, readings, readings, command.outputs, driven.motion, false);
    let reward = task_cycle(me, now, after.task);
    after.task = reward.state;
    after.fitness += reward.earned;
    let seen = vec2<f32>(pose.x, pose.y);
    let record = recorded(pose, seen, command.outputs, driven.motion, false, reward.earned, after.fitness);
    return Cycle(after, Line(record, details(after, readings, readings)));
}

fn is_over(episode: Episode, before: EpisodeState) -> bool {
    return task_ends(of_genes(episode), before.task) | robot_ends(episode.world, before.robot);
}

fn score(episode: Episode, last: EpisodeState) -> f32 {
    return task_score(of_genes(episode), last.task, last.fitness);
}
