// LCN: the area, m^2, within 1200 mm of the arena's middle and within 250 mm of a robot of the largest group at the end, whose robots
// are linked, one to another, by less than 350 mm (Francesca et al. 2015). The middle is at (0, 0). The area is that of the cells, 50
// mm wide, whose middle is in it.
const REACH: f32 = 350.0f;
const SENSED: f32 = 250.0f;
const RADIUS: f32 = 1200.0f;
const CELLS: u32 = 48u;
const CELL_SIDE: f32 = 50.0f;
const MOST: u32 = 128u;

fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    return Tally(0.0f, before);
}

fn is_within(a: vec2<f32>, b: vec2<f32>, reach: f32) -> bool {
    return squared_length(vec2<f32>(a.x - b.x, a.y - b.y)) < reach * reach;
}

fn mission_score(episode: Episode, own: MissionState, sum: f32) -> f32 {
    let count = robots(episode);
    // Each robot's group is the lowest number in it: links pass it on, as often as there are robots.
    var groups_of = array<u32, MOST>();
    for (var robot = 0u; robot < count; robot++) {
        groups_of[robot] = robot;
    }
    for (var turn = 0u; turn < count; turn++) {
        for (var robot = 0u; robot < count; robot++) {
            let at = robot_pose(episode, robot).xy;
            for (var other = 0u; other < robot; other++) {
                let lower = min(groups_of[robot], groups_of[other]);
                if (is_within(at, robot_pose(episode, other).xy, REACH) & (groups_of[robot] != groups_of[other])) {
                    groups_of[robot] = lower;
                    groups_of[other] = lower;
                }
            }
        }
    }
    var largest = 0u;
    var size = 0u;
    for (var group = 0u; group < count; group++) {
        var members = 0u;
        for (var robot = 0u; robot < count; robot++) {
            members += select(0u, 1u, groups_of[robot] == group);
        }
        largest = select(largest, group, members > size);
        size = max(size, members);
    }
    var covered = 0u;
    for (var row = 0u; row < CELLS; row++) {
        for (var column = 0u; column < CELLS; column++) {
            let at = vec2<f32>((f32(column) + 0.5f) * CELL_SIDE - RADIUS, (f32(row) + 0.5f) * CELL_SIDE - RADIUS);
            var is_covered = false;
            for (var robot = 0u; robot < count; robot++) {
                let is_near = is_within(at, robot_pose(episode, robot).xy, SENSED);
                is_covered = is_covered | (is_near & (groups_of[robot] == largest));
            }
            covered += select(0u, 1u, is_covered & (squared_length(at) < RADIUS * RADIUS));
        }
    }
    return f32(covered) * 0.0025f;
}
