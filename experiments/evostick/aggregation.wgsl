// AGG: the share of robots on that black spot where there are more at the end, right or left of the arena's middle (Francesca et al.
// 2014).
fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    return Tally(0.0f, before);
}

fn mission_score(life: Life, own: MissionState, sum: f32) -> f32 {
    let count = robots(life);
    var left = 0u;
    var right = 0u;
    for (var robot = 0u; robot < count; robot++) {
        let at = robot_pose(life, robot).xy;
        let is_black = floor_at(life, at) < 0.1f;
        left += select(0u, 1u, is_black & (at.x < 0.0f));
        right += select(0u, 1u, is_black & (at.x >= 0.0f));
    }
    return f32(max(left, right)) * reciprocal(f32(count));
}
