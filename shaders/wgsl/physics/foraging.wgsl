// Episode of one forager in its on-board simulator: behave, drive, take food and bring it.

// What an episode keeps from one dispatch to the next, and its fitness so far.
struct EpisodeState {
    // where the food lies
    food: Food,
    x: f32,
    y: f32,
    heading: f32,
    fitness: f32,
    carries: u32,
    // what its behaviours remember
    escape: f32,
    straight: u32,
    turn: f32,
    wait: u32,
    unused_a: u32,
    unused_b: u32,
    unused_c: u32,
}

fn first_state(episode: Episode) -> EpisodeState {
    let pose = first_pose(episode);
    return EpisodeState(
        first_food(episode), pose.x, pose.y, pose.z, 0.0f, 0u, 0.0f, 0u, 0.0f, 0u, 0u, 0u, 0u,
    );
}

fn kept(after: EpisodeState) -> EpisodeState {
    return EpisodeState(
        food_kept(after.food), stored(after.x), stored(after.y), stored(after.heading), stored(after.fitness), after.carries,
        stored(after.escape), after.straight, stored(after.turn), after.wait, 0u, 0u, 0u,
    );
}

// Trace details of a forager: its four front proximity readings from left to right, its behaviour, and 1 if it carries
// food.
struct Details {
    front_0: f32,
    front_1: f32,
    front_2: f32,
    front_3: f32,
    behaviour: f32,
    carries: f32,
}

fn details_kept(values: Details) -> Details {
    return Details(
        stored(values.front_0), stored(values.front_1), stored(values.front_2), stored(values.front_3), values.behaviour, values.carries,
    );
}

fn cycle(episode: Episode, step: u32, before: EpisodeState) -> Cycle {
    var after = before;
    let pose = vec3<f32>(after.x, after.y, after.heading);
    let carried = after.carries != 0u;
    let deed = behave(episode, step, pose, carried, Memory(after.escape, after.straight, after.turn, after.wait));
    let moved = driven(episode, step, deed.wanted);
    let reached = driven_pose(pose, moved);
    let collided = touches(episode.world, vec2<f32>(reached.x, reached.y));

    // The wall stops a robot, which still turns.
    after.x = select(reached.x, pose.x, collided);
    after.y = select(reached.y, pose.y, collided);
    after.heading = reached.z;
    let brought = harvest(episode, step, vec2<f32>(after.x, after.y), after.food, carried);
    after.food = brought.food;
    after.carries = select(0u, 1u, brought.carries);
    after.escape = deed.memory.escape;
    after.straight = deed.memory.straight;
    after.turn = deed.memory.turn;
    after.wait = deed.memory.wait;
    after.fitness += brought.earned;

    // Wheel speeds as fractions of the maximum.
    let robot = robot_of(episode.world);
    let share = reciprocal(robot.farthest);
    let apart = robot.half_turn_path * moved.turn;
    let record = Record(
        pose.x, pose.y, pose.z, pose.x, pose.y,
        0.0f, 0.0f, (moved.forward - apart) * share, (moved.forward + apart) * share,
        select(0.0f, 1.0f, collided), brought.earned, after.fitness,
    );
    let front = deed.front;
    let details = Details(front.x, front.y, front.z, front.w, f32(deed.behaviour), select(0.0f, 1.0f, carried));
    return Cycle(after, Line(record, details));
}

fn is_over(episode: Episode, before: EpisodeState) -> bool {
    return false;
}

fn score(episode: Episode, last: EpisodeState) -> f32 {
    return last.fitness;
}
