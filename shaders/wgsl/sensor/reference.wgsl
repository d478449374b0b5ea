// The common parts of both reference models of the e-puck (RM1.1 and RM1.2 of demiurge-epuck-dao, with the sensors of ARGoS's e-puck,
// argos3-epuck): eight rays of proximity, lamps, the floor, and messages that robots hear. docs/swarms.md has the sources.

// The first cells of a model's numbers; LAMP_CELL follows, with a cell for each lamp.
struct ReferenceCell {
    // maximum errors of the readings of proximity, light and the floor
    proximity_noise: f32,
    light_noise: f32,
    ground_noise: f32,
    // the squared distance within which robots hear each other, mm^2
    hearing_squared: f32,
}

struct SignalCell {
    // a message of which 16 random bits are less than this is lost
    lost: f32,
    attraction: f32,
    // heights of bodies and of walls, mm
    body_height: f32,
    wall_height: f32,
}

fn reference_of(world: u32) -> ReferenceCell {
    let cell = numbers(world, REFERENCE_CELL);
    return ReferenceCell(cell.x, cell.y, cell.z, cell.w);
}

fn signals_of(world: u32) -> SignalCell {
    let cell = numbers(world, REFERENCE_CELL + 1u);
    return SignalCell(cell.x, cell.y, cell.z, cell.w);
}

// A lamp: where it is, how high, and the inverse of its intensity.
fn lamp_of(world: u32, lamp: u32) -> vec4<f32> {
    return numbers(world, LAMP_CELL + lamp);
}

// Blocks of random numbers of the sensors, after those of a list of sensors.
const PROXIMITY_BLOCK: u32 = 0x8000u;
const LIGHT_BLOCK: u32 = 0x8002u;
const GROUND_BLOCK: u32 = 0x8004u;
const GREY_BLOCK: u32 = 0x8005u;

// An error from -most to most.
fn errors(episode: Episode, step: u32, block: u32, most: f32) -> vec4<f32> {
    return most * (2.0f * units(random_words(episode.key, STREAM_SENSOR, step, block)) - 1.0f);
}

fn share4(x: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(share_of(x.x), share_of(x.y), share_of(x.z), share_of(x.w));
}

// A number within 0 and 1, 0 if it is so small that its product with a gene might be subnormal.
fn share_of(x: f32) -> f32 {
    return flushed(clamp(x, 0.0f, 1.0f));
}

// Rays of proximity: from 36 mm from the body's centre, 50 mm long, at 11.25 degrees counter-clockwise from straight ahead and each
// 45 degrees on. What a ray begins in it doesn't meet: a body that touches the robot may be between its beginning and its centre.
const RAY_BEGIN: f32 = 36.0f;
const RAY_END: f32 = 86.0f;
const RAY_0: vec2<f32> = vec2<f32>(0.98078528f, 0.19509032f);
const RAY_1: vec2<f32> = vec2<f32>(0.55557023f, 0.83146961f);

// Distances along rays from the body's centre: of four rays a quarter turn apart, and of the four between.
struct Rays {
    even: vec4<f32>,
    odd: vec4<f32>,
}

// A vector turned by the angle of a unit vector, and back.
fn turned_by(v: vec2<f32>, by: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(v.x * by.x - v.y * by.y, v.x * by.y + v.y * by.x);
}

fn turned_back(v: vec2<f32>, by: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(v.x * by.x + v.y * by.y, v.y * by.x - v.x * by.y);
}

// A body as four rays meet it, from its centre as the first ray has it: along and to the left. It is so far away that one ray at
// most does.
fn body_met(free: vec4<f32>, to: vec2<f32>, body_squared: f32) -> vec4<f32> {
    let ahead = abs(to.x);
    let left = abs(to.y);
    let aside = min(ahead, left);
    let half = body_squared - aside * aside;
    if (half <= 0.0f) {
        return free;
    }
    let distance = max(ahead, left) - root(half);
    let seen = select(RAY_END, distance, distance >= RAY_BEGIN);
    let is_ahead = ahead > left;
    return vec4<f32>(
        select(free.x, min(free.x, seen), is_ahead & (to.x > 0.0f)),
        select(free.y, min(free.y, seen), !is_ahead & (to.y > 0.0f)),
        select(free.z, min(free.z, seen), is_ahead & (to.x < 0.0f)),
        select(free.w, min(free.w, seen), !is_ahead & (to.y < 0.0f)),
    );
}

// The side of a convex arena that is `gap` away, in the direction of a unit vector in the form of the first of four rays.
fn side_met(free: vec4<f32>, toward_side: vec2<f32>, gap: f32) -> vec4<f32> {
    let ahead = side_along(abs(toward_side.x), gap);
    let left = side_along(abs(toward_side.y), gap);
    return vec4<f32>(
        select(free.x, min(free.x, ahead), toward_side.x > 0.0f),
        select(free.y, min(free.y, left), toward_side.y > 0.0f),
        select(free.z, min(free.z, ahead), toward_side.x < 0.0f),
        select(free.w, min(free.w, left), toward_side.y < 0.0f),
    );
}

fn side_along(share: f32, gap: f32) -> f32 {
    let distance = gap * reciprocal(max(share, 0x1p-20f));
    return select(RAY_END, distance, distance >= RAY_BEGIN);
}

// The same for any object, ray by ray.
fn object_met(free: vec4<f32>, shape: u32, at: vec2<f32>, ahead: vec2<f32>) -> vec4<f32> {
    let left = vec2<f32>(-ahead.y, ahead.x);
    return vec4<f32>(
        min(free.x, object_along(shape, at, ahead)),
        min(free.y, object_along(shape, at, left)),
        min(free.z, object_along(shape, at, vec2<f32>(-ahead.x, -ahead.y))),
        min(free.w, object_along(shape, at, vec2<f32>(-left.x, -left.y))),
    );
}

fn object_along(shape: u32, at: vec2<f32>, ahead: vec2<f32>) -> f32 {
    let distance = ray_to_shape(shape, at, ahead, RAY_END);
    return select(RAY_END, distance, distance >= RAY_BEGIN);
}

// How far the rays of a robot that stands at `at`, with its heading as a unit vector, are free.
fn rays_free(episode: Episode, at: vec2<f32>, heading: vec2<f32>) -> Rays {
    let world = episode.world;
    let even = turned_by(RAY_0, heading);
    let odd = turned_by(RAY_1, heading);
    var free = Rays(vec4<f32>(RAY_END), vec4<f32>(RAY_END));
    let first = worlds[world].first_shape;
    for (var index = 0u; index < INNER_COUNT; index++) {
        let shape = first + index;
        if (squared_length(toward(shape, at)) < shapes[shape].reach_squared) {
            free.even = object_met(free.even, shape, at, even);
            free.odd = object_met(free.odd, shape, at, odd);
        }
    }
    for (var index = 0u; index < SIDE_COUNT; index++) {
        let shape = first + INNER_COUNT + index;
        // The inside is to the left of a side.
        let along = vec2<f32>(shapes[shape].unit_x, shapes[shape].unit_y);
        let gap = along.x * (at.y - shapes[shape].y) - along.y * (at.x - shapes[shape].x);
        if (gap < RAY_END) {
            let outward = vec2<f32>(along.y, -along.x);
            free.even = side_met(free.even, turned_back(outward, even), gap);
            free.odd = side_met(free.odd, turned_back(outward, odd), gap);
        }
    }
    let members = members_of(world);
    let body_squared = members.body * members.body;
    let reach = RAY_END + members.body;
    let count = member_count(world);
    for (var other = 0u; other < count; other++) {
        let there = place_in(member_at(episode, other), MEMBER_X);
        let to = vec2<f32>(there.x - at.x, there.y - at.y);
        if ((other != episode.member) & (squared_length(to) < reach * reach)) {
            free.even = body_met(free.even, turned_back(to, even), body_squared);
            free.odd = body_met(free.odd, turned_back(to, odd), body_squared);
        }
    }
    return free;
}

// The reading of a ray that is free so far.
fn nearness4(free: vec4<f32>) -> vec4<f32> {
    let d = free - RAY_BEGIN;
    let reading = d * (d * 0.000298701f - 0.0368961f) + 1.08212f;
    return select(clamp(reading, vec4<f32>(0.0f), vec4<f32>(1.0f)), vec4<f32>(0.0f), free >= vec4<f32>(RAY_END));
}

// Eight readings, the rays counter-clockwise from the first.
struct Ring {
    first: vec4<f32>,
    last: vec4<f32>,
}

fn proximity(episode: Episode, step: u32, at: vec2<f32>, heading: vec2<f32>) -> Ring {
    let free = rays_free(episode, at, heading);
    let even = nearness4(free.even);
    let odd = nearness4(free.odd);
    let most = reference_of(episode.world).proximity_noise;
    return Ring(
        share4(vec4<f32>(even.x, odd.x, even.y, odd.y) + errors(episode, step, PROXIMITY_BLOCK, most)),
        share4(vec4<f32>(even.z, odd.z, even.w, odd.w) + errors(episode, step, PROXIMITY_BLOCK + 1u, most)),
    );
}

// Nominal directions of the readings, in turns and as unit vectors: 17, 50, 90, 150, 210, 270, 310 and 343 degrees. Light sensors
// look there, and sums of the proximity readings take these directions.
const LOOKS_FIRST: vec4<f32> = vec4<f32>(0.04722222f, 0.1388889f, 0.25f, 0.4166667f);
const LOOKS_LAST: vec4<f32> = vec4<f32>(0.5833333f, 0.75f, 0.8611111f, 0.9527778f);

// The sum of eight readings, each in the direction that it is declared to look: mirrored pairs share their parts.
fn ring_sum(ring: Ring) -> vec2<f32> {
    let mirrored = vec4<f32>(ring.last.w, ring.last.z, ring.last.y, ring.last.x);
    let both = ring.first + mirrored;
    let more = ring.first - mirrored;
    return vec2<f32>(
        0.95630476f * both.x + 0.64278761f * both.y - 0.86602540f * both.w,
        0.29237170f * more.x + 0.76604444f * more.y + more.z + 0.5f * more.w,
    );
}

// A lamp's light: exp(-2 D) for a distance D in m over its intensity, and nothing beyond 2.5 m.
const DARK: f32 = 2500.0f;

// The readings of light at a place with a heading in turns. A ray rises from the floor at the body's centre to each lamp; what it
// meets hides the lamp.
fn brightness(episode: Episode, step: u32, at: vec2<f32>, heading: f32) -> Ring {
    let world = episode.world;
    var first = vec4<f32>(0.0f);
    var last = vec4<f32>(0.0f);
    for (var index = 0u; index < LIGHT_COUNT; index++) {
        let lamp = lamp_of(world, index);
        let to = vec2<f32>(lamp.x - at.x, lamp.y - at.y);
        let flat = max(squared_length(to), 0x1p-10f);
        let distance = root(flat + lamp.z * lamp.z) * lamp.w;
        if (distance <= DARK) {
            let inverse = reciprocal_root(flat);
            let ahead = vec2<f32>(to.x * inverse, to.y * inverse);
            if (!is_lamp_hidden(episode, at, ahead, flat * inverse, lamp.z)) {
                let strength = exponential(-0.002f * distance);
                let turned = direction(to) - heading;
                first += strength * facing4(turned - LOOKS_FIRST);
                last += strength * facing4(turned - LOOKS_LAST);
            }
        }
    }
    let most = reference_of(world).light_noise;
    return Ring(
        share4(first + errors(episode, step, LIGHT_BLOCK, most)),
        share4(last + errors(episode, step, LIGHT_BLOCK + 1u, most)),
    );
}

// From 1 for no angle to 0 for a quarter turn and more.
fn facing4(turned: vec4<f32>) -> vec4<f32> {
    return max(1.0f - 4.0f * abs(turned - floor(turned + 0.5f)), vec4<f32>(0.0f));
}

// Whether a body, or a wall, is in the way of a ray from the floor to a lamp, `length` away and `height` above.
fn is_lamp_hidden(episode: Episode, at: vec2<f32>, ahead: vec2<f32>, length: f32, height: f32) -> bool {
    let world = episode.world;
    let signals = signals_of(world);
    // mm ahead for each mm up
    let slope = length * reciprocal(max(height, 1.0f));
    let members = members_of(world);
    let body_squared = members.body * members.body;
    let under = min(signals.body_height * slope, length);
    let reach = under + members.body;
    let count = member_count(world);
    var hidden = false;
    for (var other = 0u; other < count; other++) {
        let there = place_in(member_at(episode, other), MEMBER_X);
        let to = vec2<f32>(there.x - at.x, there.y - at.y);
        let along = to.x * ahead.x + to.y * ahead.y;
        let aside = to.x * ahead.y - to.y * ahead.x;
        let half = body_squared - aside * aside;
        // The ray gets to the body before it has risen above it; the robot itself is at 0.
        let before = along - under;
        hidden = hidden | ((half > 0.0f) & (along > 0.0f) & ((before < 0.0f) | (before * before < half)));
    }
    let first = worlds[world].first_shape;
    let below = min(signals.wall_height * slope, length);
    for (var index = 0u; index < HIDING_COUNT; index++) {
        hidden = hidden | (ray_to_shape(first + index, at, ahead, below) < below);
    }
    return hidden;
}

// The floor by a vote: readings of three sensors in five cycles, of which more than ten are black, below 0.03, or white, above 0.85.
const BLACK: f32 = 0.03f;
const WHITE: f32 = 0.85f;
const VOTES: u32 = 10u;

// 0 for a black floor, 1 for a white one, and 0.5 for any other.
fn floor_by_vote(episode: Episode, step: u32, at: vec2<f32>, heading: vec2<f32>) -> f32 {
    let most = reference_of(episode.world).ground_noise;
    let error = errors(episode, step, GROUND_BLOCK, most);
    let left = ground_vote(episode.world, at, turned_by(vec2<f32>(30.0f, 9.0f), heading), error.x);
    let middle = ground_vote(episode.world, at, turned_by(vec2<f32>(30.0f, 0.0f), heading), error.y);
    let right = ground_vote(episode.world, at, turned_by(vec2<f32>(30.0f, -9.0f), heading), error.z);
    // Two bits each for the black and the white readings of each of the last five cycles.
    let member_words = episode.member_words;
    let votes = ((word(member_words, MEMBER_FLOOR) << 4u) & 0xfffffu) | (left + middle + right);
    put_word(member_words, MEMBER_FLOOR, votes);
    let black = (((votes & 0x33333u) * 0x11111u) >> 16u) & 15u;
    let white = ((((votes >> 2u) & 0x33333u) * 0x11111u) >> 16u) & 15u;
    return select(select(0.5f, 1.0f, white > VOTES), 0.0f, black > VOTES);
}

// 1 for a black reading, 4 for a white one.
fn ground_vote(world: u32, at: vec2<f32>, place: vec2<f32>, error: f32) -> u32 {
    let reading = clamp(ground_reading(world, vec2<f32>(at.x + place.x, at.y + place.y)) + error, 0.0f, 1.0f);
    return select(0u, 1u, reading < BLACK) | select(0u, 4u, reading > WHITE);
}

// All messages of a cycle: each robot sends one to all within its range that it sees, and each gets lost with the same probability.
// First those that are not lost are listed, and then looked at one by one: a vector of worlds needs no more turns than the world
// that has most.
fn hear(episode: Episode, step: u32) {
    let world = episode.world;
    let count = member_count(world);
    let messages = MEMBER_MESSAGES + 2u * (step % HEARD_CYCLES);
    var tail = 0u;
    for (var member = 0u; member < count; member++) {
        let member_words = member_at(episode, member);
        put_word(member_words, MEMBER_HEARD, 0u);
        put_place(member_words, messages, vec2<f32>(0.0f, 0.0f));
        tail = listed(episode, step, member, tail);
    }
    let body = members_of(world).body;
    for (var turn = 0u; turn < count * count; turn++) {
        if (turn >= tail) {
            break;
        }
        let message = word(episode.world_words, WORLD_MESSAGES + turn);
        let member_words = member_at(episode, message >> 8u);
        let at = place_in(member_words, MEMBER_X);
        let there = place_in(member_at(episode, message & 255u), MEMBER_X);
        let to = vec2<f32>(there.x - at.x, there.y - at.y);
        let squared = max(squared_length(to), 1.0f);
        let inverse = reciprocal_root(squared);
        let distance = squared * inverse;
        let ahead = vec2<f32>(to.x * inverse, to.y * inverse);
        if (!is_sender_hidden(episode, at, ahead, distance)) {
            // By the distance in cm, less two radii.
            let share = reciprocal(1.0f + 0.1f * (distance - 2.0f * body));
            let sum = place_in(member_words, messages);
            put_place(member_words, messages, vec2<f32>(sum.x + share * ahead.x, sum.y + share * ahead.y));
            put_word(member_words, MEMBER_HEARD, word(member_words, MEMBER_HEARD) + 1u);
            keep_sender(member_words, message & 255u);
        }
    }
}

// Lists the messages to a robot that are not lost, eight by eight random numbers; returns the number of all so far.
fn listed(episode: Episode, step: u32, member: u32, before: u32) -> u32 {
    let world = episode.world;
    let count = member_count(world);
    let member_words = member_at(episode, member);
    let key = vec2<u32>(word(member_words, MEMBER_KEY), word(member_words, MEMBER_KEY + 1u));
    let at = place_in(member_words, MEMBER_X);
    let hearing_squared = reference_of(world).hearing_squared;
    let lost = signals_of(world).lost;
    var tail = before;
    for (var eight = 0u; eight < count; eight += 8u) {
        let draw = random_words(key, STREAM_ENVIRONMENT, step, eight);
        var words = array<u32, 8>(
            draw.x & 0xffffu, draw.x >> 16u, draw.y & 0xffffu, draw.y >> 16u,
            draw.z & 0xffffu, draw.z >> 16u, draw.w & 0xffffu, draw.w >> 16u,
        );
        for (var nth = 0u; nth < 8u; nth++) {
            let other = eight + nth;
            if ((other < count) & (other != member)) {
                let there = place_in(member_at(episode, other), MEMBER_X);
                let squared = squared_length(vec2<f32>(there.x - at.x, there.y - at.y));
                if ((f32(words[nth]) >= lost) & (squared < hearing_squared)) {
                    put_word(episode.world_words, WORLD_MESSAGES + tail, (member << 8u) | other);
                    tail++;
                }
            }
        }
    }
    return tail;
}

// Whether a body or a wall is between two robots.
fn is_sender_hidden(episode: Episode, at: vec2<f32>, ahead: vec2<f32>, distance: f32) -> bool {
    let world = episode.world;
    let members = members_of(world);
    let body_squared = members.body * members.body;
    // Neither of the two is between 0 and this.
    let before = distance - members.body;
    let count = member_count(world);
    var hidden = false;
    for (var other = 0u; other < count; other++) {
        let there = place_in(member_at(episode, other), MEMBER_X);
        let to = vec2<f32>(there.x - at.x, there.y - at.y);
        let along = to.x * ahead.x + to.y * ahead.y;
        let aside = to.x * ahead.y - to.y * ahead.x;
        hidden = hidden | ((along > 0.0f) & (along < before) & (aside * aside < body_squared));
    }
    let first = worlds[world].first_shape;
    for (var index = 0u; index < INNER_COUNT; index++) {
        hidden = hidden | (ray_to_shape(first + index, at, ahead, distance) < distance);
    }
    return hidden;
}

// What a robot heard: the number of robots in this cycle, and the attraction, a vector as the robot has it.
struct Heard {
    number: u32,
    attraction: vec2<f32>,
}

// Messages keep their direction: later turns of the robot don't turn them.
fn heard(episode: Episode, step: u32, heading: vec2<f32>) -> Heard {
    let member_words = episode.member_words;
    let now = MEMBER_MESSAGES + 2u * (step % HEARD_CYCLES);
    put_place(member_words, now, turned_back(place_in(member_words, now), heading));
    var sum = vec2<f32>(0.0f, 0.0f);
    for (var cycle = 0u; cycle < HEARD_CYCLES; cycle++) {
        sum += place_in(member_words, MEMBER_MESSAGES + 2u * cycle);
    }
    return Heard(word(member_words, MEMBER_HEARD), signals_of(episode.world).attraction * sum);
}

// 1 - 2 / (1 + e^n) for n neighbours.
fn neighbours_of(number: u32) -> f32 {
    return 1.0f - 2.0f * reciprocal(1.0f + exponential(min(f32(number), 40.0f)));
}

// A vector's parts at 45, 135, 225 and 315 degrees; 0 for those that point away.
fn quarters(v: vec2<f32>) -> vec4<f32> {
    let ahead = 0.70710678f * (v.x + v.y);
    let left = 0.70710678f * (v.y - v.x);
    return vec4<f32>(
        flushed(max(ahead, 0.0f)), flushed(max(left, 0.0f)), flushed(max(-ahead, 0.0f)), flushed(max(-left, 0.0f)),
    );
}
