// FOR: a robot on a black spot has an item, one at a time, and brings it to the white nest for a point (Francesca et al. 2014).
struct MissionState {
    // which robots have an item, a bit for each
    items: vec4<u32>,
    brought: u32,
}

fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var items = array<u32, 4>(before.items.x, before.items.y, before.items.z, before.items.w);
    var brought = 0u;
    for (var robot = 0u; robot < robots(life); robot++) {
        let floor = floor_at(life, robot_pose(life, robot).xy);
        let own = 1u << (robot & 31u);
        let others = items[robot >> 5u] & ~own;
        let is_home = floor > 0.9f;
        brought += select(0u, 1u, is_home & ((items[robot >> 5u] & own) != 0u));
        let has_item = (floor < 0.1f) | (!is_home & ((items[robot >> 5u] & own) != 0u));
        items[robot >> 5u] = others | select(0u, own, has_item);
    }
    let now = MissionState(vec4<u32>(items[0], items[1], items[2], items[3]), before.brought + brought);
    return Tally(f32(brought), now);
}
