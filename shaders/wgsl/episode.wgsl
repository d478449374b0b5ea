// The loop over a single robot's cycles: the entry of all kernels except those of swarms (`swarm`, `members`). A cycle is the
// physics': `physics/sampled` is the simulator from a robot's sampled tables, `physics/surrogate` stands in for the robot,
// `physics/foraging` is a forager's on-board simulator.

// The state after a cycle, and the cycle's trace line.
struct Cycle {
    next: EpisodeState,
    line: Line,
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let group = workgroup.x;
    if (lane >= groups[group].rollouts) {
        return;
    }
    let slot = group * LANES + lane;
    let input = groups[group].inputs - dispatch.first_input + lane;
    let world = groups[group].world;
    let key = vec2<u32>(inputs[input], inputs[input + LANES]);
    let episode = Episode(world, key, input + KEY_WORDS * LANES, inputs[input + 2u * LANES]);

    var after: EpisodeState;
    if (dispatch.step_begin == 0u) {
        after = first_state(episode);
    } else {
        after = state[slot];
    }

    let end = min(dispatch.step_end, worlds[world].steps);
    for (var step = dispatch.step_begin; step < end; step++) {
        if (is_over(episode, after)) {
            break;
        }
        let result = cycle(episode, step, after);
        after = result.next;
        if (dispatch.trace_every > 0u && (step - dispatch.trace_begin) % dispatch.trace_every == 0u) {
            let r = result.line.record;
            let record = Record(
                stored(r.x), stored(r.y), stored(r.heading), stored(r.seen_x), stored(r.seen_y),
                stored(r.left), stored(r.right), stored(r.speed_left), stored(r.speed_right),
                r.collided, stored(r.reward), stored(r.fitness),
            );
            trace[slot * dispatch.trace_records + (step - dispatch.trace_begin) / dispatch.trace_every] =
                Line(record, details_kept(result.line.details));
        }
    }

    state[slot] = kept(after);
    fitness[slot] = stored(score(episode, after));
}
