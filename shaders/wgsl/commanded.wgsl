// Single robots that are commanded from outside, cycle by cycle: this entry replaces that of `episode`. The episodes of a dispatch may be
// in any of their cycles. A line has the pose after the cycle, its reward, and what the sensors read at the beginning of the next one.

// Commands of a robot, which precede the number of cycles that its episode has had when this one is over, 0 if it begins.
const COMMANDS: u32 = 2u;

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
    let cycles = inputs[episode.genes + COMMANDS * LANES];

    // What an episode begins with is computed again for its first cycle: a stored state has lost the signs of zeros.
    var after: EpisodeState;
    if (cycles < 2u) {
        after = first_state(episode);
    } else {
        after = state[slot];
    }
    var reward = 0.0f;
    var collided = 0.0f;
    if (cycles > 0u) {
        let result = cycle(episode, cycles - 1u, after);
        after = kept(result.next);
        reward = result.line.record.reward;
        collided = result.line.record.collided;
    }
    let now = score(episode, after);
    var line = Line();
    var ends = 1.0f;
    if (!is_over(episode, after)) {
        // Only what the sensors read is taken of this cycle.
        let next = cycle(episode, cycles, after);
        line = next.line;
        ends = 0.0f;
    }
    line.record = Record(
        stored(after.x), stored(after.y), stored(after.heading), 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, ends, collided, stored(reward), stored(now),
    );
    state[slot] = kept(after);
    fitness[slot] = stored(now);
    trace[slot * dispatch.trace_records] = Line(line.record, details_kept(line.details));
}
