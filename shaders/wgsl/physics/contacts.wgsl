// Bodies that meet: robots, and the pucks of lib/pucks.wgsl. Each robot wants to get to where it would be if it were alone; then bodies
// push each other apart and out of objects, or stop. After a cycle no two bodies, and no body and no object, overlap by more than
// OVERLAP: bodies that do, and those that are in the way of such a body's return, are back where they were.

// mm, in the distance of two bodies' centres, and of a centre and an object.
const OVERLAP: f32 = 1.0f;
// Less than this, mm, is no overlap that pushes.
const TOUCH: f32 = 0x1p-6f;
// How often bodies that overlap push each other in a cycle, at most.
const PUSHES: u32 = 12u;
// The farthest that a body gets in a cycle, as a fraction of its radius: less than from its centre to the nearest wall, so that
// it comes out of a wall on the side that it was on.
const FARTHEST: f32 = 0.75f;

// Whether a body, if it is there, and an object overlap by more than `less`, mm.
fn presses(world: u32, body: u32, at: vec2<f32>, less: f32) -> bool {
    let first = near_first(world, at);
    let count = near_count(world, at);
    var hit = false;
    for (var index = 0u; index < count; index++) {
        let shape = near_shape(world, first + index);
        let near = contact_of(world, shape, body) - less;
        hit = hit | (squared_length(toward(shape, at)) < near * near);
    }
    return hit;
}

// A place pushed out of each object that the body would overlap there, one after another.
fn pushed_out(world: u32, body: u32, at: vec2<f32>) -> vec2<f32> {
    let first = near_first(world, at);
    let count = near_count(world, at);
    var place = at;
    for (var index = 0u; index < count; index++) {
        let shape = near_shape(world, first + index);
        let to = toward(shape, place);
        let squared = squared_length(to);
        let contact = contact_of(world, shape, body);
        let near = contact - TOUCH;
        if ((squared < near * near) & (squared > 0x1p-20f)) {
            let share = contact * reciprocal_root(squared) - 1.0f;
            place = vec2<f32>(place.x - share * to.x, place.y - share * to.y);
        }
    }
    return place;
}

// Whether two bodies whose centres were so far apart before the current push overlapped by more than TOUCH. Bodies at one place to a
// thousandth of a millimetre don't: they have no direction to part in.
fn overlapped(episode: Episode, of_robots: Apart, squared: f32, body: u32, other: u32) -> bool {
    return (squared < apart_of(episode, of_robots, TOUCH, body, other).near_squared) & (squared > 0x1p-20f);
}

// By what share of the way from the second to the first of two bodies that overlapped the first gives way, and the second.
fn shares_of_way(episode: Episode, of_robots: Apart, squared: f32, first: u32, second: u32) -> vec2<f32> {
    let touching = apart_of(episode, of_robots, TOUCH, first, second).touching;
    let overlap = touching * reciprocal_root(squared) - 1.0f;
    let part = share_of_first(episode.world, first, second);
    return vec2<f32>(part * overlap, (part - 1.0f) * overlap);
}

// How far around itself a body looks for others, mm, of which lib/neighbours.wgsl makes something: here each looks at all.
fn reach_to_touching(episode: Episode) -> f32 {
    return 0.0f;
}

// Of `count` bodies, one and those after it that overlapped give way to each other: each to the others in the order of their numbers, on which the
// rounding of sums depends. Returns whether any did.
fn push_others(episode: Episode, of_robots: Apart, count: u32, member: u32, reach: f32) -> bool {
    let member_words = member_at(episode, member);
    let at = place_in(member_words, MEMBER_BEFORE);
    var moved = place_in(member_words, MEMBER_GOAL);
    var pushed = false;
    for (var other = member + 1u; other < count; other++) {
        let another = member_at(episode, other);
        let beside = place_in(another, MEMBER_BEFORE);
        let away = vec2<f32>(at.x - beside.x, at.y - beside.y);
        let squared = squared_length(away);
        if (overlapped(episode, of_robots, squared, member, other)) {
            let share = shares_of_way(episode, of_robots, squared, member, other);
            moved = vec2<f32>(moved.x + share.x * away.x, moved.y + share.x * away.y);
            let gone = place_in(another, MEMBER_GOAL);
            put_place(another, MEMBER_GOAL, vec2<f32>(gone.x + share.y * away.x, gone.y + share.y * away.y));
            pushed = true;
        }
    }
    put_place(member_words, MEMBER_GOAL, moved);
    return pushed;
}

// Bodies that overlap give way by their shares of each overlap, all at once. Returns whether any did.
fn push(episode: Episode) -> bool {
    let count = body_count(episode.world);
    let of_robots = apart_by(2.0f * members_of(episode.world).body, TOUCH);
    let reach = reach_to_touching(episode);
    var pushed = false;
    for (var member = 0u; member < count; member++) {
        let member_words = member_at(episode, member);
        put_word(member_words, MEMBER_BEFORE, word(member_words, MEMBER_GOAL));
        put_word(member_words, MEMBER_BEFORE + 1u, word(member_words, MEMBER_GOAL + 1u));
    }
    for (var member = 0u; member < count; member++) {
        pushed = push_others(episode, of_robots, count, member, reach) | pushed;
    }
    // Only a world that has objects looks at them.
    if (worlds[episode.world].shapes > 0u) {
        for (var member = 0u; member < count; member++) {
            let member_words = member_at(episode, member);
            let at = place_in(member_words, MEMBER_GOAL);
            if (is_on_floor(episode, member)) {
                let out = pushed_out(episode.world, member, at);
                pushed = pushed | (out.x != at.x) | (out.y != at.y);
                put_place(member_words, MEMBER_GOAL, out);
            }
        }
    }
    return pushed;
}

// All push until no bodies overlap, and get to MEMBER_GOAL. Bodies that still overlap by more than OVERLAP are taken back,
fn push_all(episode: Episode) {
    var times = 0u;
    for (var time = 0u; time < PUSHES; time++) {
        if (!push(episode)) {
            break;
        }
        times++;
    }
    if (times > 0u) {
        take_back(episode, times == PUSHES);
    }
}

// Whether a body at a place and another one at MEMBER_GOAL overlap by more than OVERLAP.
fn is_in_way(episode: Episode, of_robots: Apart, member: u32, at: vec2<f32>, other: u32) -> bool {
    let near_squared = apart_of(episode, of_robots, OVERLAP, member, other).near_squared;
    let beside = place_in(member_at(episode, other), MEMBER_GOAL);
    return squared_length(vec2<f32>(at.x - beside.x, at.y - beside.y)) < near_squared;
}

// Whether one of `count` bodies overlaps with another by more than OVERLAP.
fn is_pressed(episode: Episode, of_robots: Apart, count: u32, member: u32, reach: f32) -> bool {
    let at = place_in(member_at(episode, member), MEMBER_GOAL);
    var pressed = false;
    for (var other = 0u; other < count; other++) {
        pressed = pressed | (is_in_way(episode, of_robots, member, at, other) & (other != member));
    }
    return pressed;
}

// The first `queued` bodies of the queue return to where they were. Bodies in the way of one that returns are queued behind them, and
// return too. Each turn of the loop looks at one body, whether it is in the way of the one at the queue's head.
fn queue_those_in_way(episode: Episode, of_robots: Apart, queued: u32, reach: f32) {
    let count = body_count(episode.world);
    var head = 0u;
    var tail = queued;
    var other = 0u;
    for (var turn = 0u; turn < count * count; turn++) {
        if (head == tail) {
            break;
        }
        let returning = word(member_at(episode, head), MEMBER_QUEUE);
        let start = place_in(member_at(episode, returning), MEMBER_X);
        let another = member_at(episode, other);
        if (is_in_way(episode, of_robots, returning, start, other) & (word(another, MEMBER_MET) == 0u)) {
            put_word(another, MEMBER_MET, 1u);
            put_word(member_at(episode, tail), MEMBER_QUEUE, other);
            tail++;
        }
        other++;
        head = select(head, head + 1u, other == count);
        other = select(other, 0u, other == count);
    }
}

// Bodies that got too far, and if `overlap` those that overlap with another or with an object, return to where they were, and
// so do those in the way of one that returns.
fn take_back(episode: Episode, overlap: bool) {
    let count = body_count(episode.world);
    let body = members_of(episode.world).body;
    let of_robots = apart_by(2.0f * body, OVERLAP);
    let reach = reach_to_touching(episode);
    var tail = 0u;
    for (var member = 0u; member < count; member++) {
        let member_words = member_at(episode, member);
        let at = place_in(member_words, MEMBER_GOAL);
        let start = place_in(member_words, MEMBER_X);
        let farthest = FARTHEST * radius_of(episode.world, body, member);
        var returns = squared_length(vec2<f32>(at.x - start.x, at.y - start.y)) > farthest * farthest;
        if (overlap & is_on_floor(episode, member)) {
            returns = returns | presses(episode.world, member, at, OVERLAP);
            returns = is_pressed(episode, of_robots, count, member, reach) | returns;
        }
        put_word(member_words, MEMBER_MET, select(0u, 1u, returns));
        if (returns) {
            put_word(member_at(episode, tail), MEMBER_QUEUE, member);
            tail++;
        }
    }
    queue_those_in_way(episode, of_robots, tail, reach);
    for (var member = 0u; member < count; member++) {
        let member_words = member_at(episode, member);
        if (word(member_words, MEMBER_MET) != 0u) {
            put_place(member_words, MEMBER_GOAL, place_in(member_words, MEMBER_X));
        }
    }
}

// One after another, by their numbers, robots get to where they want to, or stop where they are if anything is there.
fn stop_all(episode: Episode) {
    let count = member_count(episode.world);
    let apart = 2.0f * members_of(episode.world).body;
    for (var member = 0u; member < count; member++) {
        let member_words = member_at(episode, member);
        let at = place_in(member_words, MEMBER_GOAL);
        var is_free = !touches(episode.world, at);
        for (var other = 0u; other < count; other++) {
            let field = select(MEMBER_X, MEMBER_GOAL, other < member);
            let beside = place_in(member_at(episode, other), field);
            let is_near = squared_length(vec2<f32>(at.x - beside.x, at.y - beside.y)) < apart * apart;
            is_free = is_free & !(is_near & (other != member));
        }
        if (!is_free) {
            put_place(member_words, MEMBER_GOAL, place_in(member_words, MEMBER_X));
        }
    }
}
