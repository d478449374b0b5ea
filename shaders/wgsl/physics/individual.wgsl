// Episode of a parametric robot as an individual in its surroundings: the same cycle as in the simulator, with all that differs from the
// description. Every difference has a strength; with all of them at 0 the episode is bit-identical to the simulator's.

// What an episode keeps from one dispatch to the next, and its fitness so far.
struct State {
    task: TaskState,
    controller: ControllerState,
    sensor: SensorState,
    x: f32,
    y: f32,
    heading: f32,
    fitness: f32,
    robot: RobotState,
    // where its sensors were last read, and what its wheels do at the end of a cycle: mm and turns in a cycle
    read_x: f32,
    read_y: f32,
    read_heading: f32,
    displacement: f32,
    turn: f32,
}

// A cycle's motion, and what the robot remembers after it.
struct Driven {
    motion: Motion,
    state: RobotState,
}

fn first_state(episode: Episode) -> State {
    let pose = first_pose(episode);
    return State(
        task_begin(episode, pose), controller_begin(episode), sensor_begin(episode, pose),
        pose.x, pose.y, pose.z, 0.0f, RobotState(), pose.x, pose.y, pose.z, 0.0f, 0.0f,
    );
}

fn kept(own: State) -> State {
    return State(
        task_kept(own.task), controller_kept(own.controller), sensor_kept(own.sensor),
        stored(own.x), stored(own.y), stored(own.heading), stored(own.fitness), robot_kept(own.robot),
        stored(own.read_x), stored(own.read_y), stored(own.read_heading), stored(own.displacement), stored(own.turn),
    );
}

fn cycle(episode: Episode, step: u32, before: State) -> Cycle {
    let world = episode.world;
    var own = before;
    let pose = vec3<f32>(own.x, own.y, own.heading);
    let read_at = vec3<f32>(own.read_x, own.read_y, own.read_heading);
    let seen = vec2<f32>(own.read_x, own.read_y);
    let sensed = sensors_read(episode, step, read_at, own.sensor);
    own.sensor = sensed.state;
    var readings = read_out(episode, step, sense(world, read_at, seen, own.robot));
    readings.own = sensed.readings;
    let command = commands(episode, step, readings, own.controller);
    own.controller = command.state;
    let outputs = command.outputs;
    let driven = motion(episode, step, outputs, own.robot);
    own.robot = driven.state;
    let is_free = own.robot.stuck == 0u;
    var moved = driven.motion;
    moved.displacement = select(0.0f, moved.displacement, is_free);
    moved.turn = select(0.0f, moved.turn, is_free);

    // What it does really.
    let moving = moving_cell(world);
    let displacement = lagging(moving, own.displacement, moved.displacement);
    let turn = lagging(moving, own.turn, moved.turn);
    own.displacement = displacement.x;
    own.turn = turn.x;
    var really = moved;
    let ridden = by_unlike_wheels(world, displacement.y, turn.y);
    really.displacement = select(0.0f, ridden.x, is_free);
    really.turn = select(0.0f, ridden.y, is_free);
    let reached = moved_pose(world, pose, really);
    let goal = vec2<f32>(reached.x, reached.y);
    let collided = touches(world, goal);

    var turned = really.turn;
    own.x = reached.x;
    own.y = reached.y;
    own.heading = reached.z;
    if (collided) {
        let start = vec2<f32>(pose.x, pose.y);
        if (worlds[world].collision == STICK) {
            own.robot.stuck = 1u;
        } else {
            let along = slid(world, start, goal, true);
            var at = along;
            if (worlds[world].collision != SLIDE) {
                at = start + moving.slip * (along - start);
                at = select(at, start, touches(world, at));
            }
            own.x = at.x;
            own.y = at.y;
            if (worlds[world].collision == UNDO) {
                turned = moving.slip * really.turn;
                let heading = pose.z + turned;
                own.heading = select(heading - floor(heading), pose.z, turned == 0.0f);
            }
        }
    }
    let end = vec3<f32>(own.x, own.y, own.heading);
    own.robot = robot_after(world, end, own.robot);
    let reward = task_cycle(episode, Experience(step, pose, end, readings, readings, outputs, moved, collided), own.task);

    // The next readings are of some moment before the end of this cycle.
    let age = age_of_readings(episode, step);
    own.read_x = end.x - age * (end.x - pose.x);
    own.read_y = end.y - age * (end.y - pose.y);
    own.read_heading = end.z - age * turned;

    own.task = reward.state;
    own.fitness += reward.earned;
    let record = recorded(pose, seen, outputs, moved, collided, reward.earned, own.fitness);
    return Cycle(own, Line(record, details(own, readings, readings)));
}

fn is_over(episode: Episode, own: State) -> bool {
    return task_ends(episode, own.task) | robot_ends(episode.world, own.robot);
}

fn score(episode: Episode, own: State) -> f32 {
    return task_score(episode, own.task, own.fitness);
}
