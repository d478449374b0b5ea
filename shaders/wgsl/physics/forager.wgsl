// Episode of a forager with any controller and any task: sense, act, drive, take food and bring it, reward. With the behaviours
// and the task that ship its bits are those of `physics/foraging`.

// What an episode keeps from one dispatch to the next, and its fitness so far.
struct EpisodeState {
    // where the food lies
    food: Food,
    task: TaskState,
    controller: ControllerState,
    sensor: SensorState,
    x: f32,
    y: f32,
    heading: f32,
    fitness: f32,
    carries: u32,
}

// A forager's cycle, as a task sees it: that of any robot, and what became of the food.
struct Experience {
    step: u32,
    start: vec3<f32>,
    end: vec3<f32>,
    // readings before and after sensor noise
    real: Readings,
    perceived: Readings,
    // outputs of the controller, and the motion of the wheels
    outputs: vec2<f32>,
    moved: Motion,
    // whether the wall stopped it
    collided: bool,
    // whether it took an item in this cycle, or brought one to the nest, and the seconds that were then left
    took: bool,
    brought: bool,
    worth: f32,
    // from the robot's centre at the end to that of the nest, and to the nearest item, mm
    to_nest: f32,
    to_food: f32,
}

fn first_state(episode: Episode) -> EpisodeState {
    let pose = first_pose(episode);
    return EpisodeState(
        first_food(episode), task_begin(episode, pose), controller_begin(episode), sensor_begin(episode, pose),
        pose.x, pose.y, pose.z, 0.0f, 0u,
    );
}

fn kept(after: EpisodeState) -> EpisodeState {
    return EpisodeState(
        food_kept(after.food), task_kept(after.task), controller_kept(after.controller), sensor_kept(after.sensor),
        stored(after.x), stored(after.y), stored(after.heading), stored(after.fitness), after.carries,
    );
}

fn cycle(episode: Episode, step: u32, before: EpisodeState) -> Cycle {
    let world = episode.world;
    var after = before;
    let pose = vec3<f32>(after.x, after.y, after.heading);
    let carried = after.carries != 0u;
    let sensed = sensors_read(episode, step, pose, after.sensor);
    after.sensor = sensed.state;
    let seen = sense(episode, step, pose, carried, sensed.readings);
    let acted = act(episode, step, pose, seen.perceived, after.controller);
    after.controller = acted.state;
    let driven = driven(episode, step, acted.wanted);
    let reached = driven_pose(pose, driven);
    let collided = touches(world, vec2<f32>(reached.x, reached.y));

    // The wall stops a robot, which still turns.
    after.x = select(reached.x, pose.x, collided);
    after.y = select(reached.y, pose.y, collided);
    after.heading = reached.z;
    let at = vec2<f32>(after.x, after.y);
    let brought = harvest(episode, step, at, after.food, carried);
    after.food = brought.food;
    after.carries = select(0u, 1u, brought.carries);

    // Wheel speeds as fractions of the maximum.
    let robot = robot_of(world);
    let share = reciprocal(robot.farthest);
    let apart = robot.half_turn_path * driven.turn;
    let moved = Motion(
        driven.forward, driven.turn, (driven.forward - apart) * share, (driven.forward + apart) * share,
    );
    let nest = nest_of(world);
    let now = Experience(
        step, pose, vec3<f32>(at, after.heading), seen.real, seen.perceived, acted.outputs, moved, collided,
        brought.carries & !carried, carried & !brought.carries, brought.earned,
        root(squared_length(vec2<f32>(at.x - nest.x, at.y - nest.y))), nearest_food(after.food, at),
    );
    let reward = task_cycle(episode, now, after.task);
    after.task = reward.state;
    after.fitness += reward.earned;
    let record = recorded(pose, vec2<f32>(pose.x, pose.y), acted.outputs, moved, collided, reward.earned, after.fitness);
    return Cycle(after, Line(record, details(after, seen.real, seen.perceived)));
}

fn is_over(episode: Episode, before: EpisodeState) -> bool {
    return task_ends(episode, before.task);
}

fn score(episode: Episode, last: EpisodeState) -> f32 {
    return task_score(episode, last.task, last.fitness);
}
