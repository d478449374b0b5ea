// Swarms driven from outside, cycle by cycle: this part's declarations replace the same names in
// `swarm` and `controller/behaviours`. The robots' next readings are kept after the words of all
// items. Step 0 begins a world, and step N is its cycle N - 1.

// Where an order has a robot's drive, counted from its first gene, which is below 0 if the robot is not switched on.
const DRIVE_FORWARD: u32 = ORDER_AFTER - ORDER_BEFORE;
const DRIVE_TURN: u32 = DRIVE_FORWARD + 1u;

// Readings of a robot: four of proximity and eight of light.
const NEAR_READINGS: u32 = 0u;
const LIGHT_READINGS: u32 = 4u;
const READINGS: u32 = 12u;

fn behave(episode: Episode, step: u32, pose: vec3<f32>, carries: bool, before: Memory) -> Deed {
    let wanted = Drive(gene(episode, DRIVE_FORWARD), gene(episode, DRIVE_TURN));
    return Deed(wanted, SEARCH, vec4<f32>(0.0f), before);
}

// The side of the lamp in a cycle.
fn lamp_in(episode: Episode, step: u32) -> f32 {
    return select(gene(episode, LAMP_FIRST), gene(episode, LAMP_THEN), f32(step) >= gene(episode, LAMP_MOVES));
}

// A robot that is no longer switched on is as before it was, except for what it carries and has earned.
fn switch_off(episode: Episode, base: u32) {
    let count = robots(episode.world);
    for (var robot = 0u; robot < count; robot++) {
        let order = episode.genes + (ORDERS + robot * ORDER_WORDS) * LANES;
        if (input(order + (ORDER_BEFORE + GENE_LADEN) * LANES) < 0.0f) {
            let robot_words = robot_at(base, robot);
            state[robot_words + BEHAVIOUR * LANES] = OFF;
            put(robot_words, WANTED, 0.0f);
            put(robot_words, WANTED + 1u, 0.0f);
        }
    }
}

// What all sensors will read in a cycle.
fn perceive(episode: Episode, base: u32, step: u32) {
    let count = robots(episode.world);
    for (var robot = 0u; robot < count; robot++) {
        let robot_words = robot_at(base, robot);
        let pose = vec3<f32>(number(robot_words, X), number(robot_words, Y), number(robot_words, HEADING));
        let me = among(robot_episode(episode, robot_words), base, robot, pose);
        let at = food_at(base, episode.world, items(episode.world)) + robot * READINGS * LANES;
        put_four(at, NEAR_READINGS, near(me, step, pose));
        put_four(at, LIGHT_READINGS, light(me, step, 0u, pose));
        put_four(at, LIGHT_READINGS + 4u, light(me, step, 1u, pose));
    }
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let group = workgroup.x;
    if (lane >= groups[group].rollouts) {
        return;
    }
    let input_at = groups[group].inputs - dispatch.first_input + lane;
    let world = groups[group].world;
    let base = group * dispatch.state_words * LANES + lane;
    let first_line = group * dispatch.trace_records * dispatch.record_words * LANES + lane;
    var episode = Episode(
        world, vec2<u32>(inputs[input_at], inputs[input_at + LANES]), input_at + KEY_WORDS * LANES, base,
        vec4<f32>(0.0f), 0.0f, 1.0f,
    );

    if (dispatch.step_begin == 0u) {
        begin(episode, base);
    }
    let end = min(dispatch.step_end, worlds[world].steps);
    for (var step = dispatch.step_begin; step < end; step++) {
        if (step > 0u) {
            episode.lamp = lamp_in(episode, step - 1u);
            switch_off(episode, base);
            cycle(episode, base, step - 1u);
        }
        episode.lamp = lamp_in(episode, step);
        perceive(episode, base, step);
        let past = step - dispatch.trace_begin;
        if (dispatch.trace_every > 0u && past % dispatch.trace_every == 0u) {
            line(world, base, first_line + past / dispatch.trace_every * dispatch.record_words * LANES);
        }
    }
    fitness[group * LANES + lane] = f32(word(base, HARVESTED));
}
