// Episode in the simulator from a robot's sampled tables: sense, act, move, reward.

// What an episode keeps from one dispatch to the next, and its fitness so far.
struct State {
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

fn first_state(episode: Episode) -> State {
    let pose = first_pose(episode);
    let shift = first_shift(episode);
    return State(
        task_begin(episode, pose), controller_begin(episode), sensor_begin(episode, pose),
        pose.x, pose.y, pose.z, 0.0f, shift.x, shift.y, RobotState(),
    );
}

fn kept(own: State) -> State {
    return State(
        task_kept(own.task), controller_kept(own.controller), sensor_kept(own.sensor),
        stored(own.x), stored(own.y), stored(own.heading), stored(own.fitness), stored(own.shift_x), stored(own.shift_y),
        robot_kept(own.robot),
    );
}

fn cycle(episode: Episode, step: u32, before: State) -> Cycle {
    let world = episode.world;
    var own = before;
    let pose = vec3<f32>(own.x, own.y, own.heading);
    var shift = vec2<f32>(0.0f, 0.0f);
    if (worlds[world].walk_range > 0.0f) {
        shift = vec2<f32>(own.shift_x, own.shift_y);
        let next = walked(episode, step, shift);
        own.shift_x = next.x;
        own.shift_y = next.y;
    }
    let seen = vec2<f32>(pose.x + shift.x, pose.y + shift.y);
    let sensed = sensors_read(episode, step, pose, own.sensor);
    own.sensor = sensed.state;
    var real = sense(world, pose, seen, own.robot);
    real.own = sensed.readings;
    let perceived = with_noise(episode, step, real);
    let command = commands(episode, step, perceived, own.controller);
    own.controller = command.state;
    let outputs = command.outputs;
    let driven = motion(episode, step, outputs, own.robot);
    own.robot = driven.state;
    var moved = driven.motion;
    moved.displacement = select(moved.displacement, 0.0f, own.robot.stuck != 0u);
    moved.turn = select(moved.turn, 0.0f, own.robot.stuck != 0u);
    let reached = moved_pose(world, pose, moved);
    let collided = touches(world, vec2<f32>(reached.x, reached.y));

    own.x = select(reached.x, pose.x, collided);
    own.y = select(reached.y, pose.y, collided);
    own.heading = select(reached.z, pose.z, collided);
    if (worlds[world].collision != UNDO) {
        own.heading = reached.z;
        if (collided & (worlds[world].collision == SLIDE)) {
            let at = slid(world, vec2<f32>(pose.x, pose.y), vec2<f32>(reached.x, reached.y), true);
            own.x = at.x;
            own.y = at.y;
        }
        if (worlds[world].collision == STICK) {
            own.x = reached.x;
            own.y = reached.y;
            own.robot.stuck = select(own.robot.stuck, 1u, collided);
        }
    }
    let end = vec3<f32>(own.x, own.y, own.heading);
    own.robot = robot_after(world, end, own.robot);
    let reward = task_cycle(episode, Experience(step, pose, end, real, perceived, outputs, moved, collided), own.task);
    own.task = reward.state;
    own.fitness += reward.earned;
    let record = recorded(pose, seen, outputs, moved, collided, reward.earned, own.fitness);
    return Cycle(own, Line(record, details(own, real, perceived)));
}

fn is_over(episode: Episode, own: State) -> bool {
    return task_ends(episode, own.task) | robot_ends(episode.world, own.robot);
}

fn score(episode: Episode, own: State) -> f32 {
    return task_score(episode, own.task, own.fitness);
}
