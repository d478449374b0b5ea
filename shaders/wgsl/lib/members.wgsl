// A world of robots: what it keeps, and where: a block of words for the world and one for each robot, LANES
// worlds side by side, so that the same word of neighbouring worlds is next to it. One invocation is a whole world.
// `GREATEST_MEMBERS`, `WORLD_WORDS`, `MEMBER_WORDS`, `MEMBERS_CELL` and `first_gene` are generated, as are the words of what parts
// remember.

// A word of each world, before what its mission remembers: the sum of all rewards.
const WORLD_EARNED: u32 = 0u;
const WORLD_MEMORY: u32 = 1u;

// Words of each robot, before what its parts remember: where it is, and its heading.
const MEMBER_X: u32 = 0u;
const MEMBER_Y: u32 = 1u;
const MEMBER_HEADING: u32 = 2u;
// its random numbers, two words
const MEMBER_KEY: u32 = 3u;
// where it gets to in this cycle, and where that was before the current push: x and y each
const MEMBER_GOAL: u32 = 5u;
const MEMBER_BEFORE: u32 = 7u;
// where it would get to if it were alone: x and y
const MEMBER_ALONE: u32 = 9u;
// its pose before the cycle
const MEMBER_START: u32 = 11u;
// for searches among robots: whether it was met, and a queue
const MEMBER_MET: u32 = 14u;
const MEMBER_QUEUE: u32 = 15u;
const MEMBER_MEMORY: u32 = 16u;

@group(0) @binding(6) var<storage, read_write> state: array<u32>;

// An episode: the world, the key of its random numbers, the index of its first gene and the number of its trial; where the world's
// words and this robot's are, and the robot's number. Of a world as a whole the key is its own, the gene that of the genome, and the robot the first.
struct Episode {
    world: u32,
    key: vec2<u32>,
    genes: u32,
    trial: u32,
    world_words: u32,
    member_words: u32,
    member: u32,
}

// What all robots of a world share.
struct MembersCell {
    count: f32,
    body: f32,
    // the maximum squared distance at which a robot's sensors notice another
    reach_squared: f32,
    // 1 if robots push each other, 0 if they stop
    pushes: f32,
}

fn members_of(world: u32) -> MembersCell {
    let cell = numbers(world, MEMBERS_CELL);
    return MembersCell(cell.x, cell.y, cell.z, cell.w);
}

fn member_count(world: u32) -> u32 {
    return min(u32(members_of(world).count), GREATEST_MEMBERS);
}

fn member_at(episode: Episode, member: u32) -> u32 {
    return episode.world_words + (WORLD_WORDS + member * MEMBER_WORDS) * LANES;
}

fn word(words: u32, field: u32) -> u32 {
    return state[words + field * LANES];
}

fn number(words: u32, field: u32) -> f32 {
    return bitcast<f32>(state[words + field * LANES]);
}

fn put_word(words: u32, field: u32, value: u32) {
    state[words + field * LANES] = value;
}

fn put(words: u32, field: u32, value: f32) {
    state[words + field * LANES] = bitcast<u32>(stored(value));
}

fn place_in(words: u32, field: u32) -> vec2<f32> {
    return vec2<f32>(number(words, field), number(words, field + 1u));
}

fn put_place(words: u32, field: u32, place: vec2<f32>) {
    put(words, field, place.x);
    put(words, field + 1u, place.y);
}

fn member_pose(member_words: u32) -> vec3<f32> {
    return vec3<f32>(number(member_words, MEMBER_X), number(member_words, MEMBER_Y), number(member_words, MEMBER_HEADING));
}

// Bodies are the robots, and after them the pucks of lib/pucks.wgsl, which replaces the following functions. Here there are none.
fn body_count(world: u32) -> u32 {
    return member_count(world);
}

// Its radius, given a robot's.
fn radius_of(world: u32, robot: f32, body: u32) -> f32 {
    return robot;
}

// Whether a body is on the floor, and not carried.
fn is_on_floor(episode: Episode, body: u32) -> bool {
    return true;
}

// The distance of the centres of two bodies that touch, 0 if one is not on the floor; and the square of the distance at which they
// overlap by more than something.
struct Apart {
    touching: f32,
    near_squared: f32,
}

fn apart_by(touching: f32, overlap: f32) -> Apart {
    let near = max(touching - overlap, 0.0f);
    return Apart(touching, near * near);
}

// The same of two bodies, given that of two robots: loops over pairs compute that once.
fn apart_of(episode: Episode, robots: Apart, overlap: f32, body: u32, other: u32) -> Apart {
    return robots;
}

// The part of an overlap by which the first of two bodies gives way, and the other by the rest.
fn share_of_first(world: u32, body: u32, other: u32) -> f32 {
    return 0.5f;
}

// The distance from an object's points at which a body touches it, and whether one there does.
fn contact_of(world: u32, shape: u32, body: u32) -> f32 {
    return shapes[shape].contact;
}

fn body_touches(world: u32, body: u32, at: vec2<f32>) -> bool {
    return touches(world, at);
}

// The body that gets a place at the start after so many others, a drawn place for it, and its heading.
fn body_by_turn(world: u32, turn: u32) -> u32 {
    return turn;
}

fn start_of_body(world: u32, body: u32, u: vec4<f32>) -> vec2<f32> {
    return start_place(world, body, u);
}

fn heading_of_body(world: u32, body: u32, drawn: f32) -> f32 {
    return start_heading(world, body, drawn);
}

// What pucks do before bodies push each other, and after.
fn pucks_wait(episode: Episode) {
}

fn pucks_move(episode: Episode) {
}

// Lists bodies by where they are, for searches of those near a place, where lib/neighbours.wgsl has them.
fn list_bodies(episode: Episode) {
}

// A robot of a world, given the world's episode.
fn member_episode(episode: Episode, member: u32) -> Episode {
    let member_words = member_at(episode, member);
    let key = vec2<u32>(word(member_words, MEMBER_KEY), word(member_words, MEMBER_KEY + 1u));
    return Episode(episode.world, key, first_gene(episode, member), episode.trial, episode.world_words, member_words, member);
}

// Functions of the swarm for users' parts; docs/swarms.md lists them.

// Number of robots in the world.
fn robots(episode: Episode) -> u32 {
    return member_count(episode.world);
}

// The number of the robot that this is, from 0.
fn robot_number(episode: Episode) -> u32 {
    return episode.member;
}

// Where a robot is: x and y in mm, heading in turns. Beyond the last it is the last.
fn robot_pose(episode: Episode, robot: u32) -> vec3<f32> {
    return member_pose(member_at(episode, min(robot, member_count(episode.world) - 1u)));
}

// The grey of the floor at a place.
fn floor_at(episode: Episode, place: vec2<f32>) -> f32 {
    return ground_reading(episode.world, place);
}

// Robots or pucks in clusters.
struct Clusters {
    // number of clusters, and of bodies in the largest
    count: u32,
    largest: u32,
}

// Robots linked to each other, directly or through others, where less than `reach` mm lies between the centres of two.
fn clusters_within(episode: Episode, reach: f32) -> Clusters {
    return clusters_of(episode, 0u, member_count(episode.world), reach);
}

// The same of bodies: `count` of them from `begin` on.
fn clusters_of(episode: Episode, begin: u32, bodies: u32, reach: f32) -> Clusters {
    let count = min(bodies, GREATEST_MEMBERS);
    for (var member = 0u; member < count; member++) {
        put_word(member_at(episode, begin + member), MEMBER_MET, 0u);
    }
    // Each turn of the loop looks at one body: whether it begins a cluster, or belongs to the one that is being followed. A vector
    // of worlds then needs no more turns than the world that needs most.
    var found = Clusters(0u, 0u);
    var first = 0u;
    // the next body to look at from `here`; after the last, none
    var other = count;
    var here = vec2<f32>(0.0f, 0.0f);
    var head = 0u;
    var tail = 0u;
    var size = 0u;
    for (var turn = 0u; turn < count * (count + 1u); turn++) {
        if ((other == count) & (head < tail)) {
            here = place_in(member_at(episode, word(member_at(episode, begin + head), MEMBER_QUEUE)), MEMBER_X);
            head++;
            other = 0u;
        }
        let is_followed = other < count;
        if (!is_followed & (first == count)) {
            break;
        }
        let body = begin + select(first, other, is_followed);
        let at = member_at(episode, body);
        let there = place_in(at, MEMBER_X);
        let squared = squared_length(vec2<f32>(there.x - here.x, there.y - here.y));
        let is_in = !is_followed | (squared < reach * reach);
        if ((word(at, MEMBER_MET) == 0u) & is_in) {
            put_word(at, MEMBER_MET, 1u);
            put_word(member_at(episode, begin + tail), MEMBER_QUEUE, body);
            tail++;
            size = select(1u, size + 1u, is_followed);
            found.count += select(1u, 0u, is_followed);
        }
        other += select(0u, 1u, is_followed);
        first += select(1u, 0u, is_followed);
        found.largest = max(found.largest, size);
    }
    return found;
}
