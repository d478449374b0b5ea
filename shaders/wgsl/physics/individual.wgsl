// Episode of a parametric robot as an individual in its surroundings: the same cycle as in the simulator, with all that differs from the
// description. Every difference has a strength; with all of them at 0 the episode is bit-identical to the simulator's.

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

fn first_state(episode: Episode) -> EpisodeState {
    let pose = first_pose(episode);
    return EpisodeState(
        task_begin(episode, pose), controller_begin(episode), sensor_begin(episode, pose),
        pose.x, pose.y, pose.z, 0.0f, RobotState(), pose.x, pose.y, pose.z, 0.0f, 0.0f,
    );
}

fn kept(after: EpisodeState) -> EpisodeState {
    return EpisodeState(
        task_kept(after.task), controller_kept(after.controller), sensor_kept(after.sensor),
        stored(after.x), stored(after.y), stored(after.heading), stored(after.fitness), robot_kept(after.robot),
        stored(after.read_x), stored(after.read_y), stored(after.read_heading), stored(after.displacement), stored(after.turn),
    );
}

fn cycle(episode: Episode, step: u32, before: EpisodeState) -> Cycle {
    let world = episode.world;
    var after = before;
    let pose = vec3<f32>(after.x, after.y, after.heading);
    let read_at = vec3<f32>(after.read_x, after.read_y, after.read_heading);
    let seen = vec2<f32>(after.read_x, after.read_y);
    let sensed = sensors_read(episode, step, read_at, after.sensor);
    after.sensor = sensed.state;
    var readings = read_out(episode, step, sense(world, read_at, seen, after.robot));
    readings.own = sensed.readings;
    let command = commands(episode, step, readings, after.controller);
    after.controller = command.state;
    let outputs = command.outputs;
    let driven = motion(episode, step, outputs, after.robot);
    after.robot = driven.state;
    let is_free = after.robot.stuck == 0u;
    var moved = driven.motion;
    moved.displacement = select(0.0f, moved.displacement, is_free);
    moved.turn = select(0.0f, moved.turn, is_free);

    // What it does really.
    let moving = moving_cell(world);
    let displacement = lagging(moving, after.displacement, moved.displacement);
    let turn = lagging(moving, after.turn, moved.turn);
    after.displacement = displacement.x;
    after.turn = turn.x;
    var really = moved;
    let ridden = by_unlike_wheels(world, displacement.y, turn.y);
    really.displacement = select(0.0f, ridden.x, is_free);
    really.turn = select(0.0f, ridden.y, is_free);
    let reached = moved_pose(world, pose, really);
    let goal = vec2<f32>(reached.x, reached.y);
    let collided = touches(world, goal);

    var turned = really.turn;
    after.x = reached.x;
    after.y = reached.y;
    after.heading = reached.z;
    if (collided) {
        let start = vec2<f32>(pose.x, pose.y);
        if (worlds[world].collision == STICK) {
            after.robot.stuck = 1u;
        } else {
            let along = slid(world, start, goal, true);
            var at = along;
            if (worlds[world].collision != SLIDE) {
                at = start + moving.slip * (along - start);
                at = select(at, start, touches(world, at));
            }
            after.x = at.x;
            after.y = at.y;
            if (worlds[world].collision == UNDO) {
                turned = moving.slip * really.turn;
                let heading = pose.z + turned;
                after.heading = select(heading - floor(heading), pose.z, turned == 0.0f);
            }
        }
    }
    let end = vec3<f32>(after.x, after.y, after.heading);
    after.robot = robot_after(world, end, after.robot);
    let reward = task_cycle(episode, Experience(step, pose, end, readings, readings, outputs, moved, collided), after.task);

    // The next readings are of some moment before the end of this cycle.
    let age = age_of_readings(episode, step);
    after.read_x = end.x - age * (end.x - pose.x);
    after.read_y = end.y - age * (end.y - pose.y);
    after.read_heading = end.z - age * turned;

    after.task = reward.state;
    after.fitness += reward.earned;
    let record = recorded(pose, seen, outputs, moved, collided, reward.earned, after.fitness);
    return Cycle(after, Line(record, details(after, readings, readings)));
}

fn is_over(episode: Episode, before: EpisodeState) -> bool {
    return task_ends(episode, before.task) | robot_ends(episode.world, before.robot);
}

fn score(episode: Episode, last: EpisodeState) -> f32 {
    return task_score(episode, last.task, last.fitness);
}
