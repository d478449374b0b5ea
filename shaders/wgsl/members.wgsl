// Worlds of robots, cycle by cycle: the entry of composed kernels of swarms.

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let group = workgroup.x;
    if (lane >= groups[group].rollouts) {
        return;
    }
    let slot = group * LANES + lane;
    let input = groups[group].inputs - dispatch.first_input + lane;
    let world = groups[group].world;
    let words = group * dispatch.state_words * LANES + lane;
    let key = vec2<u32>(inputs[input], inputs[input + LANES]);
    let trial = inputs[input + 2u * LANES];
    let episode = Episode(world, key, input + KEY_WORDS * LANES, trial, words, words + WORLD_WORDS * LANES, 0u);

    if (dispatch.step_begin == 0u) {
        begin(episode);
    }
    let end = min(dispatch.step_end, worlds[world].steps);
    for (var step = dispatch.step_begin; step < end; step++) {
        if (mission_ends(episode, mission_loaded(episode.world_words))) {
            break;
        }
        let result = cycle(episode, step);
        if (dispatch.trace_every > 0u && (step - dispatch.trace_begin) % dispatch.trace_every == 0u) {
            traced(episode, result, slot * dispatch.trace_records + (step - dispatch.trace_begin) / dispatch.trace_every);
        }
    }
    fitness[slot] = stored(score(episode));
}
