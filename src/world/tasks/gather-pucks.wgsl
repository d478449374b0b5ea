// Push pucks together. Fitness: the share of the pucks that are in the largest cluster at the end of the episode, and how much nearer the
// pucks have come to their middle, times their weights. Pucks with less than a gap between them are linked, also through others.

struct TaskValues {
    gap: f32, // 20, 0 to 10000 mm: gap between linked pucks
    cluster: f32, // 1, 0 to 1000: weight of the share of pucks in the largest cluster
    nearness: f32, // 1, 0 to 1000: weight of the part of their distance from their middle that is gone, squared
}

struct MissionState {
    spread: f32,
}

// The sum of the squares of the pucks' distances from their middle, in units of a puck's radius.
fn spread_of_pucks(episode: Episode) -> f32 {
    let count = f32(pucks(episode));
    var middle = vec2<f32>(0.0, 0.0);
    for (var i = 0u; i < pucks(episode); i++) {
        middle += puck_place(episode, i) / count;
    }
    var sum = 0.0;
    for (var i = 0u; i < pucks(episode); i++) {
        let away = (puck_place(episode, i) - middle) / puck_radius(episode);
        sum += dot(away, away);
    }
    return sum;
}

fn mission_begin(episode: Episode) -> MissionState {
    return MissionState(max(spread_of_pucks(episode), 1.0));
}

fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    return Tally(0.0, before);
}

fn mission_score(episode: Episode, memory: MissionState, sum: f32) -> f32 {
    let own = task_values(episode);
    let reach = 2.0 * puck_radius(episode) + own.gap;
    let share = f32(puck_clusters_within(episode, reach).largest) / f32(pucks(episode));
    let gone = 1.0 - min(spread_of_pucks(episode) / memory.spread, 1.0);
    return own.cluster * share + own.nearness * gone;
}
