// Episode in the simulator from a robot's sampled tables: sense, act, move, reward.

// What an episode keeps from one dispatch to the next, and its fitness so far.
struct EpisodeState {
    task: TaskState,
    controller: ControllerState,
    sensor: SensorState,
    x: f32,
    y: f32,
    heading: f32,
    fitness: f32,
    // what the conservative noise displaces perception by
    shift_x: f32,
    shift_y: f32,
    robot: RobotState,
}

// A cycle's motion, and what the robot remembers after it.
struct Driven {
    motion: Motion,
    state: RobotState,
}

fn first_state(episode: Episode) -> EpisodeState {
    let pose = first_pose(episode);
    let shift = first_shift(episode);
    return EpisodeState(
        task_begin(episode, pose), controller_begin(episode), sensor_begin(episode, pose),
        pose.x, pose.y, pose.z, 0.0f, shift.x, shift.y, RobotState(),
    );
}

fn kept(after: EpisodeState) -> EpisodeState {
    return EpisodeState(
        task_kept(after.task), controller_kept(after.controller), sensor_kept(after.sensor),
        stored(after.x), stored(after.y), stored(after.heading), stored(after.fitness), stored(after.shift_x), stored(after.shift_y),
        robot_kept(after.robot),
    );
}

fn cycle(episode: Episode, step: u32, before: EpisodeState) -> Cycle {
    let world = episode.world;
    var after = before;
    let pose = vec3<f32>(after.x, after.y, after.heading);
    var shift = vec2<f32>(0.0f, 0.0f);
    if (worlds[world].walk_range > 0.0f) {
        shift = vec2<f32>(after.shift_x, after.shift_y);
        let next = walked(episode, step, shift);
        after.shift_x = next.x;
        after.shift_y = next.y;
    }
    let seen = vec2<f32>(pose.x + shift.x, pose.y + shift.y);
    let sensed = sensors_read(episode, step, pose, after.sensor);
    after.sensor = sensed.state;
    var real = sense(world, pose, seen, after.robot);
    real.own = sensed.readings;
    let perceived = with_noise(episode, step, real);
    let command = commands(episode, step, perceived, after.controller);
    after.controller = command.state;
    let outputs = command.outputs;
    let driven = motion(episode, step, outputs, after.robot);
    after.robot = driven.state;
    var moved = driven.motion;
    moved.displacement = select(moved.displacement, 0.0f, after.robot.stuck != 0u);
    moved.turn = select(moved.turn, 0.0f, after.robot.stuck != 0u);
    let reached = moved_pose(world, pose, moved);
    let collided = touches(world, vec2<f32>(reached.x, reached.y));

    after.x = select(reached.x, pose.x, collided);
    after.y = select(reached.y, pose.y, collided);
    after.heading = select(reached.z, pose.z, collided);
    if (worlds[world].collision != UNDO) {
        after.heading = reached.z;
        if (collided & (worlds[world].collision == SLIDE)) {
            let at = slid(world, vec2<f32>(pose.x, pose.y), vec2<f32>(reached.x, reached.y), true);
            after.x = at.x;
            after.y = at.y;
        }
        if (worlds[world].collision == STICK) {
            after.x = reached.x;
            after.y = reached.y;
            after.robot.stuck = select(after.robot.stuck, 1u, collided);
        }
    }
    let end = vec3<f32>(after.x, after.y, after.heading);
    after.robot = robot_after(world, end, after.robot);
    let reward = task_cycle(episode, Experience(step, pose, end, real, perceived, outputs, moved, collided), after.task);
    after.task = reward.state;
    after.fitness += reward.earned;
    let record = recorded(pose, seen, outputs, moved, collided, reward.earned, after.fitness);
    return Cycle(after, Line(record, details(after, real, perceived)));
}

fn is_over(episode: Episode, before: EpisodeState) -> bool {
    return task_ends(episode, before.task) | robot_ends(episode.world, before.robot);
}

fn score(episode: Episode, last: EpisodeState) -> f32 {
    return task_score(episode, last.task, last.fitness);
}
