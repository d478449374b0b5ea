// A mission: what a swarm earns in each cycle of 100 ms, and in an episode. Change it as you like; `oneiro check` says what is
// wrong, and where. docs/swarms.md lists the functions that a mission may call.
//
// This one counts the robots on the black spot at the end of an episode.

// What the mission remembers during an episode; all zero at its start.
struct MissionState {
    on_spot: u32,
}

// What a cycle earns, after all robots have moved, and what the mission remembers.
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var on_spot = 0u;
    for (var robot = 0u; robot < robots(episode); robot++) {
        let place = robot_pose(episode, robot).xy;
        on_spot += select(0u, 1u, floor_at(episode, place) < 0.1);
    }
    return Tally(0.0, MissionState(on_spot));
}

// The fitness, from what the mission remembers at the end, and from the sum of all that was earned.
fn mission_score(episode: Episode, memory: MissionState, sum: f32) -> f32 {
    return f32(memory.on_spot);
}
