// AGG: the share of robots on that black spot where there are more at the end, right or left of the arena's middle (Francesca et al.
// 2014).
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    return Tally(0.0f, before);
}

fn mission_score(episode: Episode, own: MissionState, sum: f32) -> f32 {
    let count = robots(episode);
    var left = 0u;
    var right = 0u;
    for (var robot = 0u; robot < count; robot++) {
        let at = robot_pose(episode, robot).xy;
        let is_black = floor_at(episode, at) < 0.1f;
        left += select(0u, 1u, is_black & (at.x < 0.0f));
        right += select(0u, 1u, is_black & (at.x >= 0.0f));
    }
    return f32(max(left, right)) * reciprocal(f32(count));
}
