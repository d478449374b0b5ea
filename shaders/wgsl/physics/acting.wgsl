// Behaviours of a forager outside the kernel: its readings are reported, and the trace has the commands to
// drive.

// What an episode keeps from one dispatch to the next: what its behaviours remember.
struct EpisodeState {
    escape: f32,
    straight: u32,
    turn: f32,
    wait: u32,
}

// Trace details: the commanded way and turn of a cycle, mm and turns, and its behaviour.
struct Details {
    forward: f32,
    turn: f32,
    behaviour: u32,
}

fn first_state(episode: Episode) -> EpisodeState {
    return EpisodeState(0.0f, 0u, 0.0f, 0u);
}

fn kept(after: EpisodeState) -> EpisodeState {
    return EpisodeState(stored(after.escape), after.straight, stored(after.turn), after.wait);
}

fn details_kept(values: Details) -> Details {
    return Details(stored(values.forward), stored(values.turn), values.behaviour);
}

fn cycle(episode: Episode, step: u32, before: EpisodeState) -> Cycle {
    let nowhere = vec3<f32>(0.0f, 0.0f, 0.0f);
    let memory = Memory(before.escape, before.straight, before.turn, before.wait);
    let deed = behave(episode, step, nowhere, carries(episode), memory);
    let next = EpisodeState(deed.memory.escape, deed.memory.straight, deed.memory.turn, deed.memory.wait);
    let record = Record(0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f);
    return Cycle(next, Line(record, Details(deed.wanted.forward, deed.wanted.turn, deed.behaviour)));
}

fn is_over(episode: Episode, before: EpisodeState) -> bool {
    return false;
}

fn score(episode: Episode, last: EpisodeState) -> f32 {
    return 0.0f;
}
