// Pucks: discs that robots push, and carry. Its declarations replace those of lib/members.wgsl with the same names. Pucks are bodies
// like robots, with the numbers after the last robot; they give way where they are pushed, and stay where nothing pushes them. `PUCKS_CELL`,
// `PUCKS_FIRST`, `MEMBER_HELD` and `puck_start` are generated.

// What all pucks share.
struct PucksCell {
    count: f32,
    // mm
    radius: f32,
    // the part of an overlap with a robot by which a puck gives way
    yields: f32,
    // the gap between a robot and a puck within which it can be taken, mm; 0 without grippers
    grip: f32,
}

// A puck is put down so far before the robot, mm.
const PUT_DOWN: f32 = 0x1p-4f;

fn pucks_of(world: u32) -> PucksCell {
    let cell = numbers(world, PUCKS_CELL);
    return PucksCell(cell.x, cell.y, cell.z, cell.w);
}

fn puck_count(world: u32) -> u32 {
    return min(u32(pucks_of(world).count), GREATEST_MEMBERS);
}

fn body_count(world: u32) -> u32 {
    return min(member_count(world) + puck_count(world), GREATEST_MEMBERS);
}

fn is_puck(world: u32, body: u32) -> bool {
    return body >= member_count(world);
}

fn radius_of(world: u32, robot: f32, body: u32) -> f32 {
    return select(robot, pucks_of(world).radius, is_puck(world, body));
}

// MEMBER_HELD of a robot is the puck that it carries, and of a puck the robot that carries it; their numbers from 1, and 0 for none.
fn is_on_floor(episode: Episode, body: u32) -> bool {
    return !is_puck(episode.world, body) | (word(member_at(episode, body), MEMBER_HELD) == 0u);
}

fn apart_of(episode: Episode, robots: Apart, overlap: f32, body: u32, other: u32) -> Apart {
    let robot = 0.5f * robots.touching;
    let touching = radius_of(episode.world, robot, body) + radius_of(episode.world, robot, other);
    return apart_by(select(0.0f, touching, is_on_floor(episode, body) & is_on_floor(episode, other)), overlap);
}

fn share_of_first(world: u32, body: u32, other: u32) -> f32 {
    let yields = pucks_of(world).yields;
    let first = is_puck(world, body);
    return select(select(1.0f - yields, yields, first), 0.5f, first == is_puck(world, other));
}

fn contact_of(world: u32, shape: u32, body: u32) -> f32 {
    let robot = members_of(world).body;
    return shapes[shape].contact + (radius_of(world, robot, body) - robot);
}

fn body_touches(world: u32, body: u32, at: vec2<f32>) -> bool {
    return presses(world, body, at, 0.0f);
}

fn body_by_turn(world: u32, turn: u32) -> u32 {
    let all = puck_count(world);
    return select(turn, select(turn - all, turn + member_count(world), turn < all), PUCKS_FIRST);
}

fn start_of_body(world: u32, body: u32, u: vec4<f32>) -> vec2<f32> {
    if (is_puck(world, body)) {
        return puck_start(world, body - member_count(world), u);
    }
    return start_place(world, body, u);
}

fn heading_of_body(world: u32, body: u32, drawn: f32) -> f32 {
    if (is_puck(world, body)) {
        return drawn;
    }
    return start_heading(world, body, drawn);
}

fn pucks_wait(episode: Episode) {
    for (var body = member_count(episode.world); body < body_count(episode.world); body++) {
        let words = member_at(episode, body);
        let at = place_in(words, MEMBER_X);
        put_place(words, MEMBER_START, at);
        put_place(words, MEMBER_GOAL, at);
    }
}

// Pucks get to where they were pushed, and carried ones to where their robots are.
fn pucks_move(episode: Episode) {
    for (var body = member_count(episode.world); body < body_count(episode.world); body++) {
        let words = member_at(episode, body);
        let held = word(words, MEMBER_HELD);
        var at = place_in(words, MEMBER_GOAL);
        if (held > 0u) {
            at = place_in(member_at(episode, held - 1u), MEMBER_X);
        }
        put_place(words, MEMBER_X, at);
    }
}

// Functions of pucks for users' parts; docs/pucks.md lists them.

// Number of pucks, and the radius of each in mm.
fn pucks(episode: Episode) -> u32 {
    return puck_count(episode.world);
}

fn puck_radius(episode: Episode) -> f32 {
    return pucks_of(episode.world).radius;
}

// The words of a puck by its number, from 0. Beyond the last it is the last.
fn puck_words(episode: Episode, puck: u32) -> u32 {
    return member_at(episode, min(member_count(episode.world) + puck, body_count(episode.world) - 1u));
}

// Where a puck is, mm; that of its robot while it is carried.
fn puck_place(episode: Episode, puck: u32) -> vec2<f32> {
    return place_in(puck_words(episode, puck), MEMBER_X);
}

// Whether a robot carries a puck, and whether this robot carries one.
fn is_carried(episode: Episode, puck: u32) -> bool {
    return word(puck_words(episode, puck), MEMBER_HELD) != 0u;
}

fn carries_puck(episode: Episode) -> bool {
    return word(episode.member_words, MEMBER_HELD) != 0u;
}

// Pucks linked to each other, as robots in `clusters_within`.
fn puck_clusters_within(episode: Episode, reach: f32) -> Clusters {
    return clusters_of(episode, member_count(episode.world), puck_count(episode.world), reach);
}

// The robot takes the nearest puck on the floor whose centre is at most an eighth of a turn off its heading and that is within the reach
// of its gripper; of equally near ones the first. Whether it carries a puck then.
fn take_puck(episode: Episode) -> bool {
    let world = episode.world;
    let count = member_count(world);
    let pose = member_pose(episode.member_words);
    let ahead = cosine_sine(pose.z);
    let reach = members_of(world).body + pucks_of(world).radius + pucks_of(world).grip;
    var nearest = select(0.0f, reach * reach, pucks_of(world).grip > 0.0f);
    var taken = 0u;
    for (var puck = 0u; puck < puck_count(world); puck++) {
        let words = member_at(episode, count + puck);
        let there = place_in(words, MEMBER_X);
        let to = vec2<f32>(there.x - pose.x, there.y - pose.y);
        let squared = squared_length(to);
        let is_ahead = to.x * ahead.x + to.y * ahead.y >= abs(to.x * ahead.y - to.y * ahead.x);
        if (is_ahead & (squared < nearest) & (word(words, MEMBER_HELD) == 0u)) {
            nearest = squared;
            taken = puck + 1u;
        }
    }
    if ((taken > 0u) & !carries_puck(episode)) {
        put_word(episode.member_words, MEMBER_HELD, taken);
        let words = member_at(episode, count + taken - 1u);
        put_word(words, MEMBER_HELD, episode.member + 1u);
        put_place(words, MEMBER_X, vec2<f32>(pose.x, pose.y));
    }
    return carries_puck(episode);
}

// The robot puts its puck down in front of it, if nothing is there. Whether it carries none then.
fn put_puck(episode: Episode) -> bool {
    let world = episode.world;
    let held = word(episode.member_words, MEMBER_HELD);
    if (held == 0u) {
        return true;
    }
    let pose = member_pose(episode.member_words);
    let body = min(member_count(world) + held, GREATEST_MEMBERS) - 1u;
    let away = members_of(world).body + pucks_of(world).radius + PUT_DOWN;
    let place = vec2<f32>(pose.x, pose.y) + away * cosine_sine(pose.z);
    var is_free = !body_touches(world, body, place);
    for (var other = 0u; other < body_count(world); other++) {
        let words = member_at(episode, other);
        let there = place_in(words, MEMBER_X);
        let apart = pucks_of(world).radius + radius_of(world, members_of(world).body, other);
        let is_near = squared_length(vec2<f32>(there.x - place.x, there.y - place.y)) < apart * apart;
        is_free = is_free & !(is_near & (other != episode.member) & is_on_floor(episode, other));
    }
    if (is_free) {
        put_place(member_at(episode, body), MEMBER_X, place);
        put_word(member_at(episode, body), MEMBER_HELD, 0u);
        put_word(episode.member_words, MEMBER_HELD, 0u);
        list_bodies(episode);
    }
    return is_free;
}
