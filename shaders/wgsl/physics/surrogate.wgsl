// Episode as a surrogate of a real robot: the same cycle as in the simulator, by physics that its samples don't
// contain. Every difference has a strength; with all of them at 0 the episode is the simulator's.

// What an episode keeps from one dispatch to the next, and its fitness so far.
struct EpisodeState {
    task: TaskState,
    controller: ControllerState,
    sensor: SensorState,
    x: f32,
    y: f32,
    heading: f32,
    fitness: f32,
    // where its sensors were last read, and its wheels' speeds in mm/s
    read_x: f32,
    read_y: f32,
    read_heading: f32,
    speed_left: f32,
    speed_right: f32,
}

fn first_state(episode: Episode) -> EpisodeState {
    let pose = first_pose(episode);
    return EpisodeState(
        task_begin(episode, pose), controller_begin(episode), sensor_begin(episode, pose),
        pose.x, pose.y, pose.z, 0.0f, pose.x, pose.y, pose.z, 0.0f, 0.0f,
    );
}

fn kept(after: EpisodeState) -> EpisodeState {
    return EpisodeState(
        task_kept(after.task), controller_kept(after.controller), sensor_kept(after.sensor),
        stored(after.x), stored(after.y), stored(after.heading), stored(after.fitness),
        stored(after.read_x), stored(after.read_y), stored(after.read_heading),
        stored(after.speed_left), stored(after.speed_right),
    );
}

fn cycle(episode: Episode, step: u32, before: EpisodeState) -> Cycle {
    let world = episode.world;
    var after = before;
    let pose = vec3<f32>(after.x, after.y, after.heading);
    let read_at = vec3<f32>(after.read_x, after.read_y, after.read_heading);
    let sensed = sensors_read(episode, step, read_at, after.sensor);
    after.sensor = sensed.state;
    var readings = sense_by_rays(episode, step, read_at);
    readings.own = sensed.readings;
    let command = commands(episode, step, readings, after.controller);
    after.controller = command.state;
    let outputs = command.outputs;
    let moved = commanded(world, outputs);
    let end = reached(world, pose, vec2<f32>(after.speed_left, after.speed_right), moved);
    let heading = end.pose.z - floor(end.pose.z);
    let there = vec3<f32>(end.pose.x, end.pose.y, heading);
    let now = Experience(step, pose, there, readings, readings, outputs, moved, end.collided);
    let reward = task_cycle(episode, now, after.task);

    // The next readings are of some moment before the end of this cycle: of the latency and, since the sensors
    // are read on their own clock, up to a period of it more.
    let timing = timing_of(world);
    let early = unit(random_words(episode.key, STREAM_SENSOR, step, 2u).x);
    let age = min(timing.latency + timing.period * early, 1.0f);
    after.read_x = end.pose.x - age * (end.pose.x - pose.x);
    after.read_y = end.pose.y - age * (end.pose.y - pose.y);
    after.read_heading = end.pose.z - age * (end.pose.z - pose.z);

    after.x = end.pose.x;
    after.y = end.pose.y;
    after.heading = heading;
    after.task = reward.state;
    after.fitness += reward.earned;
    after.speed_left = end.left;
    after.speed_right = end.right;
    let seen = vec2<f32>(before.read_x, before.read_y);
    let record = recorded(pose, seen, outputs, moved, end.collided, reward.earned, after.fitness);
    return Cycle(after, Line(record, details(after, readings, readings)));
}

fn is_over(episode: Episode, before: EpisodeState) -> bool {
    return task_ends(episode, before.task);
}

fn score(episode: Episode, last: EpisodeState) -> f32 {
    return task_score(episode, last.task, last.fitness);
}
