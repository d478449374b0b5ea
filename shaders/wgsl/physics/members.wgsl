// One cycle of a world of robots: all sense and decide by where all are, all move at once, bodies that meet push
// each other or stop, and then robots and the mission earn. Nothing depends on the order of robots but what says so.

// A cycle's motion, and what the robot remembers after it.
struct Driven {
    motion: Motion,
    state: RobotState,
}

// What a robot and the world remember, for traces.
struct EpisodeState {
    episode: Episode,
    task: TaskState,
    controller: ControllerState,
    sensor: SensorState,
    mission: MissionState,
    robot: RobotState,
}

// What a robot read and did in a cycle.
struct Act {
    real: Readings,
    perceived: Readings,
    outputs: vec2<f32>,
    moved: Motion,
}

// What a mission gives for a cycle, and its memory after it.
struct Tally {
    earned: f32,
    state: MissionState,
}

// Draws of a body's place. Worlds have so much room that one in two is free, and bodies are looked at about as often as there
// are pairs of them and two: four times that ends a search that has no end.
const DRAWS: u32 = 64u;
const LOOKS: u32 = 4u;

fn begin(episode: Episode) {
    let count = member_count(episode.world);
    put(episode.world_words, WORLD_EARNED, 0.0f);
    for (var member = 0u; member < body_count(episode.world); member++) {
        let member_words = member_at(episode, member);
        for (var field = 0u; field < MEMBER_WORDS; field++) {
            put_word(member_words, field, 0u);
        }
        let key = random_words(episode.key, STREAM_START, 0u, 0xff00u + member);
        put_word(member_words, MEMBER_KEY, key.x);
        put_word(member_words, MEMBER_KEY + 1u, key.y);
    }
    place_bodies(episode);
    list_bodies(episode);
    for (var member = 0u; member < count; member++) {
        let me = member_episode(episode, member);
        let pose = member_pose(me.member_words);
        save_sensor(me.member_words, sensor_begin(me, pose));
        save_controller(me.member_words, controller_begin(me));
        save_task(me.member_words, task_begin(me, pose));
    }
    save_mission(episode.world_words, mission_begin(episode));
}

// Starts of robots and pucks: random free places in the field, or the given places. One after the other gets a place. Each turn of the
// loop draws one, or looks at one other body from there: a vector of worlds then needs no more turns than the world that needs most.
fn place_bodies(episode: Episode) {
    let world = episode.world;
    let count = body_count(world);
    let of_robots = apart_by(2.0f * members_of(world).body, 0.0f);
    var placed = 0u;
    var draws = 0u;
    // whether a place was drawn, how many others have been looked at from there, and whether none is too near
    var drawn = false;
    var looked_at = 0u;
    var is_free = true;
    for (var turn = 0u; turn < DRAWS * count + LOOKS * count * count; turn++) {
        if (placed == count) {
            break;
        }
        let body = body_by_turn(world, placed);
        let body_words = member_at(episode, body);
        if (drawn) {
            let other = body_by_turn(world, looked_at);
            let there = place_in(member_at(episode, other), MEMBER_X);
            let here = place_in(body_words, MEMBER_X);
            let squared = squared_length(vec2<f32>(there.x - here.x, there.y - here.y));
            is_free = is_free & (squared >= apart_of(episode, of_robots, 0.0f, body, other).near_squared);
            looked_at++;
        } else {
            let key = vec2<u32>(word(body_words, MEMBER_KEY), word(body_words, MEMBER_KEY + 1u));
            let u = units(random_words(key, STREAM_START, 0u, draws));
            let at = start_of_body(world, body, u);
            draws++;
            if (!body_touches(world, body, at)) {
                put_place(body_words, MEMBER_X, at);
                put(body_words, MEMBER_HEADING, heading_of_body(world, body, u.z));
                drawn = true;
                looked_at = 0u;
                is_free = true;
            } else if (draws == DRAWS) {
                put_place(body_words, MEMBER_X, vec2<f32>(worlds[world].start_x, worlds[world].start_y));
            }
        }
        if (drawn & (looked_at == placed)) {
            drawn = false;
            draws = select(draws, DRAWS, is_free);
        }
        if (!drawn & (draws == DRAWS)) {
            placed++;
            draws = 0u;
        }
    }
}

// What a robot reads.
fn look(me: Episode, step: u32) -> Act {
    let member_words = me.member_words;
    let pose = member_pose(member_words);
    let sensed = sensors_read(me, step, pose, sensor_loaded(member_words));
    save_sensor(member_words, sensed.state);
    var read = Act();
    read.real = sense(me, step, pose, vec2<f32>(pose.x, pose.y), robot_loaded(member_words));
    read.real.own = sensed.readings;
    read.perceived = with_noise(me, step, read.real);
    return read;
}

// A robot decides by what it reads and drives: where it would get to if it were alone.
fn act(me: Episode, step: u32, read: Act) -> Act {
    let member_words = me.member_words;
    let pose = member_pose(member_words);
    let command = commands(me, step, read.perceived, controller_loaded(member_words));
    save_controller(member_words, command.state);
    let driven = motion(me, step, command.outputs, robot_loaded(member_words));
    save_robot(member_words, driven.state);
    let reached = moved_pose(me.world, pose, driven.motion);
    let alone = vec2<f32>(reached.x, reached.y);
    var goal = alone;
    if ((members_of(me.world).pushes > 0.0f) & (worlds[me.world].shapes > 0u)) {
        goal = slid(me.world, vec2<f32>(pose.x, pose.y), alone, true);
    }
    put_place(member_words, MEMBER_START, vec2<f32>(pose.x, pose.y));
    put_place(member_words, MEMBER_ALONE, alone);
    put_place(member_words, MEMBER_GOAL, goal);
    // Others act by its heading before the cycle: both are exchanged at the end.
    put(member_words, MEMBER_START + 2u, reached.z);
    return Act(read.real, read.perceived, command.outputs, driven.motion);
}

// Whether a robot's cycle ended elsewhere than it would have if the robot were alone.
fn was_in_contact(member_words: u32) -> bool {
    let end = place_in(member_words, MEMBER_X);
    let alone = place_in(member_words, MEMBER_ALONE);
    return (end.x != alone.x) | (end.y != alone.y);
}

// What a task sees of a robot's cycle.
fn experience(member_words: u32, step: u32, did: Act) -> Experience {
    let start = vec3<f32>(place_in(member_words, MEMBER_START), number(member_words, MEMBER_START + 2u));
    return Experience(
        step, start, member_pose(member_words), did.real, did.perceived, did.outputs, did.moved, was_in_contact(member_words),
    );
}

// A robot's pose at the start of the cycle.
fn member_started(episode: Episode, member: u32) -> vec3<f32> {
    let member_words = member_at(episode, member);
    return vec3<f32>(place_in(member_words, MEMBER_START), number(member_words, MEMBER_START + 2u));
}

// What the world earns in a cycle, what of it no single robot does, and what the first robot did.
struct Cycle {
    earned: f32,
    together: f32,
    first: Act,
}

// Before robots act they see where all are, and hear each other.
fn look_around(episode: Episode, step: u32) {
    list_bodies(episode);
    hear(episode, step);
}

fn seen(me: Episode, step: u32) -> Act {
    return look(me, step);
}

fn cycle(episode: Episode, step: u32) -> Cycle {
    let count = member_count(episode.world);
    var first = Act();
    look_around(episode, step);
    for (var member = 0u; member < count; member++) {
        let me = member_episode(episode, member);
        let did = act(me, step, seen(me, step));
        keep_act(me.member_words, did);
        if (member == 0u) {
            first = did;
        }
    }
    pucks_wait(episode);
    if (members_of(episode.world).pushes > 0.0f) {
        push_all(episode);
    } else {
        stop_all(episode);
    }
    for (var member = 0u; member < count; member++) {
        let member_words = member_at(episode, member);
        put_word(member_words, MEMBER_X, word(member_words, MEMBER_GOAL));
        put_word(member_words, MEMBER_Y, word(member_words, MEMBER_GOAL + 1u));
        let heading = word(member_words, MEMBER_HEADING);
        put_word(member_words, MEMBER_HEADING, word(member_words, MEMBER_START + 2u));
        put_word(member_words, MEMBER_START + 2u, heading);
        save_robot(member_words, robot_after(episode.world, member_pose(member_words), robot_loaded(member_words)));
    }
    pucks_move(episode);
    var earned = members_earned(episode, step);
    let tally = mission_cycle(episode, step, mission_loaded(episode.world_words));
    save_mission(episode.world_words, tally.state);
    earned += tally.earned;
    put(episode.world_words, WORLD_EARNED, number(episode.world_words, WORLD_EARNED) + earned);
    return Cycle(earned, tally.earned, first);
}

// A robot's trace line of a cycle, given what it did, and what the world earned in this cycle and so far.
fn line(me: Episode, did: Act, earned: f32, total: f32) -> Line {
    let member_words = me.member_words;
    let start = member_started(me, me.member);
    let r = recorded(start, vec2<f32>(start.x, start.y), did.outputs, did.moved, was_in_contact(member_words), earned, total);
    let record = Record(
        stored(r.x), stored(r.y), stored(r.heading), stored(r.seen_x), stored(r.seen_y),
        stored(r.left), stored(r.right), stored(r.speed_left), stored(r.speed_right),
        r.collided, stored(r.reward), stored(r.fitness),
    );
    let memory = EpisodeState(
        me, task_loaded(member_words), controller_loaded(member_words), sensor_loaded(member_words), mission_loaded(me.world_words),
        robot_loaded(member_words),
    );
    return Line(record, details_kept(details(memory, did.real, did.perceived)));
}

fn score(episode: Episode) -> f32 {
    return mission_score(episode, mission_loaded(episode.world_words), number(episode.world_words, WORLD_EARNED));
}
