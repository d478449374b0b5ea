// One cycle of a world of robots: all sense and decide by where all are, all move at once, bodies that overlap push each
// other apart, then food changes hands and messages are heard. Nothing depends on the order of robots.

// The behaviour of a robot that is not switched on; the others are the controller's.
const OFF: u32 = 4u;
// How often bodies that overlap push each other in a cycle.
const PUSHES: u32 = 4u;

fn robot_key(robot_words: u32) -> vec2<u32> {
    return vec2<u32>(word(robot_words, KEY), word(robot_words, KEY + 1u));
}

fn robot_episode(episode: Episode, robot_words: u32) -> Episode {
    return Episode(episode.world, robot_key(robot_words), episode.genes, robot_words, episode.others, episode.lamp, episode.share);
}

// Draws of a robot's place, and how often robots are looked at in all before their places are taken as drawn: drivers may
// leave longer loops, and bodies that overlap push each other apart.
const DRAWS: u32 = 64u;
const LOOKS: u32 = 20000u;

// Robots anywhere in the arena, none on another, and food outside the nest.
fn begin(episode: Episode, base: u32) {
    let world = episode.world;
    let count = robots(world);
    state[base + HARVESTED * LANES] = 0u;
    for (var robot = 0u; robot < count; robot++) {
        let robot_words = robot_at(base, robot);
        for (var field = 0u; field < ROBOT_WORDS; field++) {
            state[robot_words + field * LANES] = 0u;
        }
        let key = random_words(episode.key, STREAM_START, 0u, 0xff00u + robot);
        state[robot_words + KEY * LANES] = key.x;
        state[robot_words + (KEY + 1u) * LANES] = key.y;
        state[robot_words + BEHAVIOUR * LANES] = OFF;
        differ(world, robot_words, robot);
    }
    place_robots(world, base, count);
    begin_food(episode, base);
}

// One robot after the other gets a place. Each turn of the loop draws one, or looks at one other robot from there: a
// vector of worlds then needs no more turns than the world that needs most.
fn place_robots(world: u32, base: u32, count: u32) {
    let radius = arena_of(world).radius;
    let body = robot_of(world).radius;
    var looks = 0u;
    var robot = 0u;
    var draws = 0u;
    // whether a place was drawn, how many others have been looked at from there, and whether none is too near
    var drawn = false;
    var looked_at = 0u;
    var free = true;
    for (var turn = 0u; turn < DRAWS * count + LOOKS + count * count; turn++) {
        if (robot == count) {
            break;
        }
        let robot_words = robot_at(base, robot);
        if (drawn) {
            let place = robot_at(base, looked_at);
            let apart = vec2<f32>(number(place, X) - number(robot_words, X), number(place, Y) - number(robot_words, Y));
            free = free & (squared_length(apart) >= 4.0f * body * body);
            looked_at++;
        } else {
            let u = units(random_words(robot_key(robot_words), STREAM_START, 0u, draws));
            let at = vec2<f32>((2.0f * u.x - 1.0f) * radius, (2.0f * u.y - 1.0f) * radius);
            draws++;
            if (!touches(world, at)) {
                put(robot_words, X, at.x);
                put(robot_words, Y, at.y);
                put(robot_words, HEADING, u.z);
                drawn = true;
                looked_at = 0u;
                free = true;
                looks += robot + 1u;
            }
        }
        if (drawn & (looked_at == robot)) {
            drawn = false;
            draws = select(draws, DRAWS, free | (looks > LOOKS));
        }
        // Of all draws none being free leaves the last one in the arena.
        if (!drawn & (draws == DRAWS)) {
            robot++;
            draws = 0u;
        }
    }
}

// A robot senses, decides and drives: where it would get to if it were alone.
fn act(episode: Episode, base: u32, robot: u32, step: u32) {
    let robot_words = robot_at(base, robot);
    let order = episode.genes + (ORDERS + robot * ORDER_WORDS) * LANES;
    let pose = vec3<f32>(number(robot_words, X), number(robot_words, Y), number(robot_words, HEADING));
    if (f32(step) == input(order + ORDER_BEGINS * LANES)) {
        put(robot_words, EARNED, 0.0f);
        state[robot_words + SINCE * LANES] = step;
    }
    let later = f32(step) >= input(order + ORDER_AT * LANES);
    var me = robot_episode(episode, robot_words);
    me.genes = order + select(ORDER_BEFORE, ORDER_AFTER, later) * LANES;
    let is_on = gene(me, GENE_LADEN) >= 0.0f;
    var to = pose;
    if (is_on) {
        me = among(me, base, robot, pose);
        let memory = Memory(number(robot_words, ESCAPE), word(robot_words, STRAIGHT), number(robot_words, TURN), word(robot_words, WAIT));
        let deed = behave(me, step, pose, word(robot_words, CARRIES) != 0u, memory);
        let delays = delays_of(episode.world);
        var wanted = deed.wanted;
        if (delays.latency > 0.0f) {
            wanted = Drive(number(robot_words, WANTED), number(robot_words, WANTED + 1u));
        }
        let moved = driven(me, step, wanted);
        // Slip shortens the way and the turn.
        let kept = 1.0f - delays.slip * unit(random_words(me.key, STREAM_ACTUATOR, step, 1u).x);
        to = driven_pose(pose, Drive(kept * moved.forward, kept * moved.turn));
        put(robot_words, ESCAPE, deed.memory.escape);
        state[robot_words + STRAIGHT * LANES] = deed.memory.straight;
        put(robot_words, TURN, deed.memory.turn);
        state[robot_words + WAIT * LANES] = deed.memory.wait;
        put(robot_words, WANTED, deed.wanted.forward);
        put(robot_words, WANTED + 1u, deed.wanted.turn);
        put(robot_words, HEADING, to.z);
        state[robot_words + BEHAVIOUR * LANES] = deed.behaviour;
    }
    put(robot_words, PUSHED, to.x);
    put(robot_words, PUSHED + 1u, to.y);
}

// Robots that overlap give way by half of each overlap, and the wall keeps them in. Of each pair the first one's turn moves both.
// Returns whether any is moved.
fn push(world: u32, base: u32, from_field: u32, to_field: u32) -> bool {
    var moves = false;
    let body = robot_of(world).radius;
    let apart = 2.0f * body;
    let room = arena_of(world).radius - body;
    let count = robots(world);
    for (var robot = 0u; robot < count; robot++) {
        let robot_words = robot_at(base, robot);
        state[robot_words + to_field * LANES] = word(robot_words, from_field);
        state[robot_words + (to_field + 1u) * LANES] = word(robot_words, from_field + 1u);
    }
    for (var robot = 0u; robot < count; robot++) {
        let robot_words = robot_at(base, robot);
        let x = number(robot_words, from_field);
        let y = number(robot_words, from_field + 1u);
        var moved = vec2<f32>(number(robot_words, to_field), number(robot_words, to_field + 1u));
        for (var other = robot + 1u; other < count; other++) {
            let at = robot_at(base, other);
            let away = vec2<f32>(x - number(at, from_field), y - number(at, from_field + 1u));
            let squared = squared_length(away);
            // Bodies at one place to a thousandth of a millimetre have no direction to part in.
            if ((squared < apart * apart) & (squared > 0x1p-20f)) {
                moves = true;
                let share = 0.5f * (apart * reciprocal_root(squared) - 1.0f);
                moved.x += share * away.x;
                moved.y += share * away.y;
                put(at, to_field, number(at, to_field) - share * away.x);
                put(at, to_field + 1u, number(at, to_field + 1u) - share * away.y);
            }
        }
        let squared = squared_length(moved);
        if (squared > room * room) {
            moves = true;
            let share = room * reciprocal_root(squared);
            moved.x *= share;
            moved.y *= share;
        }
        put(robot_words, to_field, moved.x);
        put(robot_words, to_field + 1u, moved.y);
    }
    return moves;
}

fn cycle(episode: Episode, base: u32, step: u32) {
    let count = robots(episode.world);
    for (var robot = 0u; robot < count; robot++) {
        act(episode, base, robot, step);
    }
    for (var time = 0u; time < PUSHES; time++) {
        let from_field = PUSHED + 2u * (time & 1u);
        let to_field = PUSHED + 2u * ((time + 1u) & 1u);
        // If none is moved now, none will be later.
        if (!push(episode.world, base, from_field, to_field)) {
            break;
        }
    }
    for (var robot = 0u; robot < count; robot++) {
        let robot_words = robot_at(base, robot);
        state[robot_words + X * LANES] = word(robot_words, PUSHED);
        state[robot_words + Y * LANES] = word(robot_words, PUSHED + 1u);
    }
    share_food(episode, base, step);
    // Each listens once a second, and no two neighbours in number at once.
    for (var robot = (SECOND - step % SECOND) % SECOND; robot < count; robot += SECOND) {
        listen(episode, base, robot, step);
    }
}

// Whom a robot hears: everybody within range whose message gets through and whom no body hides.
fn listen(episode: Episode, base: u32, robot: u32, step: u32) {
    let meeting = meeting_of(episode.world);
    let count = robots(episode.world);
    let robot_words = robot_at(base, robot);
    let at = vec2<f32>(number(robot_words, X), number(robot_words, Y));
    for (var block = 0u; block < count; block += 32u) {
        var candidates = 0u;
        for (var other = block; other < min(block + 32u, count); other++) {
            let place = robot_at(base, other);
            let to = vec2<f32>(number(place, X) - at.x, number(place, Y) - at.y);
            let chance = unit(random_words(robot_key(robot_words), STREAM_ENVIRONMENT, step, 0x8000u + other).x);
            let talks = (word(robot_words, BEHAVIOUR) != OFF) & (word(place, BEHAVIOUR) != OFF);
            let is_heard = (other != robot) & talks & (squared_length(to) <= meeting.squared_range) & (chance < meeting.heard);
            candidates |= select(0u, 1u << (other & 31u), is_heard);
        }
        // Few can be heard, and every lane hears others: each turn takes every lane's next one.
        var heard = candidates;
        for (var turn = 0u; turn < 32u; turn++) {
            if (candidates == 0u) {
                break;
            }
            let other = block + lowest_bit(candidates);
            let place = robot_at(base, other);
            let to = vec2<f32>(number(place, X) - at.x, number(place, Y) - at.y);
            if (hidden(episode.world, base, robot, other, at, to)) {
                heard &= ~(candidates & (0u - candidates));
            }
            candidates &= candidates - 1u;
        }
        let field = robot_words + (HEARD + block / 32u) * LANES;
        state[field] |= heard;
    }
}

// Whether a third body is in the way.
fn hidden(world: u32, base: u32, robot: u32, other: u32, at: vec2<f32>, to: vec2<f32>) -> bool {
    var is_hidden = false;
    if (meeting_of(world).line_of_sight > 0.0f) {
        let body = robot_of(world).radius;
        let squared = squared_length(to);
        let count = robots(world);
        for (var third = 0u; third < count; third++) {
            let place = robot_at(base, third);
            let between = vec2<f32>(number(place, X) - at.x, number(place, Y) - at.y);
            let along = between.x * to.x + between.y * to.y;
            let aside = between.y * to.x - between.x * to.y;
            let is_between = (along > 0.0f) & (along < squared) & (aside * aside < body * body * squared);
            is_hidden = is_hidden | (is_between & (third != robot) & (third != other));
        }
    }
    return is_hidden;
}
