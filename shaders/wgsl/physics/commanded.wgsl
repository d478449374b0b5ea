// Worlds of robots that are commanded from outside, cycle by cycle: this part's declarations replace the same names in `members` and
// `physics/members`. All robots have looked at the end of the cycle before, as sensors may remember what they read. The worlds of a dispatch
// may be in any of their cycles. A robot's line has its pose after the cycle, its own reward and that of the mission, and what it reads at
// the beginning of the next cycle. `MEMBER_EARNED` is generated.

// Commands of a robot, which precede the number of cycles that its episode has had when this one is over, 0 if it begins.
const COMMANDS: u32 = 2u;

fn look_around(episode: Episode, step: u32) {
}

fn seen(me: Episode, step: u32) -> Act {
    return act_kept(me.member_words);
}

fn keep_earned(member_words: u32, earned: f32) {
    put(member_words, MEMBER_EARNED, earned);
}

fn keep_sender(member_words: u32, sender: u32) {
}

// A cycle of the robots, after which their episode has had so many. Their lines begin there in the trace. Returns the fitness so far.
fn commanded_cycle(episode: Episode, cycles: u32, first_line: u32) -> f32 {
    let count = member_count(episode.world);
    var together = 0.0f;
    if (cycles == 0u) {
        begin(episode);
    } else {
        together = cycle(episode, cycles - 1u).together;
    }
    let now = score(episode);
    let is_over = mission_ends(episode, mission_loaded(episode.world_words));
    if (!is_over) {
        list_bodies(episode);
        hear(episode, cycles);
    }
    for (var member = 0u; member < count; member++) {
        let me = member_episode(episode, member);
        let member_words = me.member_words;
        let pose = member_pose(member_words);
        let collided = (cycles > 0u) & was_in_contact(member_words);
        var reads = Act();
        if (!is_over) {
            reads = look(me, cycles);
            keep_act(member_words, reads);
        }
        let record = Record(
            stored(pose.x), stored(pose.y), stored(pose.z), 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, select(0.0f, 1.0f, is_over),
            select(0.0f, 1.0f, collided), stored(number(member_words, MEMBER_EARNED) + together), stored(now),
        );
        trace[first_line + member] = Line(record, details_kept(details(EpisodeState(), reads.real, reads.perceived)));
    }
    return stored(now);
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
    let words = group * dispatch.state_words * LANES + lane;
    let key = vec2<u32>(inputs[input], inputs[input + LANES]);
    let trial = inputs[input + 2u * LANES];
    let episode = Episode(world, key, input + KEY_WORDS * LANES, trial, words, words + WORLD_WORDS * LANES, 0u);
    let cycles = inputs[episode.genes + COMMANDS * LANES];
    fitness[slot] = commanded_cycle(episode, cycles, slot * member_count(world));
}
