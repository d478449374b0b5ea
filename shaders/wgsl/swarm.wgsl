// Worlds of robots that meet: the entry of the kernel in which one invocation is a whole world, cycle by cycle. What
// changes during an episode comes with the inputs of each dispatch, so that an episode goes on under new orders.

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
        let moved = f32(step) >= gene(episode, LAMP_MOVES);
        episode.lamp = select(gene(episode, LAMP_FIRST), gene(episode, LAMP_THEN), moved);
        cycle(episode, base, step);
        let past = step + 1u - dispatch.trace_begin;
        if (dispatch.trace_every > 0u && past % dispatch.trace_every == 0u) {
            line(world, base, first_line + (past / dispatch.trace_every - 1u) * dispatch.record_words * LANES);
        }
    }
    fitness[group * LANES + lane] = f32(word(base, HARVESTED));
}

// A line of the trace: where all are after a cycle, and what happened since the line before.
fn line(world: u32, base: u32, at: u32) {
    let count = robots(world);
    let masks = (count + 31u) / 32u;
    var place = at;
    for (var robot = 0u; robot < count; robot++) {
        let robot_words = robot_at(base, robot);
        trace[place + LINE_X * LANES] = word(robot_words, X);
        trace[place + LINE_Y * LANES] = word(robot_words, Y);
        trace[place + LINE_HEADING * LANES] = word(robot_words, HEADING);
        trace[place + LINE_DOES * LANES] =
            word(robot_words, BEHAVIOUR) | (word(robot_words, CARRIES) << LINE_CARRIES) | (word(robot_words, BROUGHT) << LINE_BROUGHT);
        trace[place + LINE_EARNED * LANES] = word(robot_words, EARNED);
        place += LINE_WORDS * LANES;
        for (var mask = 0u; mask < masks; mask++) {
            trace[place] = word(robot_words, HEARD + mask);
            state[robot_words + (HEARD + mask) * LANES] = 0u;
            place += LANES;
        }
        state[robot_words + BROUGHT * LANES] = 0u;
    }
    let food = items(world);
    for (var item = 0u; item < food; item++) {
        let item_words = food_at(base, world, item);
        trace[place] = word(item_words, ITEM_X);
        trace[place + LANES] = word(item_words, ITEM_Y);
        place += LINE_ITEM_WORDS * LANES;
    }
}
