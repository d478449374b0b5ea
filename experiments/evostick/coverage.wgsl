// CFA: 250 less 100 times the mean distance, m, from a point of the arena to the nearest robot that is not on black at the end, at most
// 2.5 m (Francesca et al. 2015). As in the published program points are drawn by their distance from the middle, uniform up to 1200 mm,
// and their angle: here they are those of a grid of both. The middle is at (0, 0).
const RADIUS: f32 = 1200.0f;
const RINGS: u32 = 24u;
const ANGLES: u32 = 48u;

fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    return Tally(0.0f, before);
}

fn mission_score(episode: Episode, own: MissionState, sum: f32) -> f32 {
    let count = robots(episode);
    var total = 0.0f;
    for (var ring = 0u; ring < RINGS; ring++) {
        let distance = RADIUS * (f32(ring) + 0.5f) * 0.041666668f;
        for (var angle = 0u; angle < ANGLES; angle++) {
            let at = distance * cosine_sine((f32(angle) + 0.5f) * 0.020833334f);
            var nearest = 2500.0f * 2500.0f;
            for (var robot = 0u; robot < count; robot++) {
                let there = robot_pose(episode, robot).xy;
                let squared = squared_length(vec2<f32>(there.x - at.x, there.y - at.y));
                nearest = select(nearest, min(nearest, squared), floor_at(episode, there) >= 0.1f);
            }
            total += root(nearest);
        }
    }
    let mean = total * 8.680556e-7f;
    return max(100.0f * (2.5f - mean), 0.0f);
}
