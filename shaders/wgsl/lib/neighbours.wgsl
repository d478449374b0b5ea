// Swarms of many bodies: squares over the arena say who may be near a place. Its declarations replace those of lib/members.wgsl and
// physics/contacts.wgsl with the same names. Results are the same bits as if each body looked at all others: what depends on an order
// is done in the order of the bodies' numbers. Squares list bodies by where they are when a cycle begins (MEMBER_LISTED); who looks
// later looks farther, by the farthest that any body is from there. WORLD_SQUARES has the first entry of each square's list, and after
// the last square the number of entries; WORLD_LISTED has the entries, which are numbers of bodies, square after square. These places,
// `SQUARES_CELL`, `MOST_SQUARES` and `MOST_ROWS` are generated.

// The squares of a world.
struct SquaresCell {
    // lower left corner, mm
    x: f32,
    y: f32,
    // squares per mm
    per_mm: f32,
    columns: f32,
}

// How far bodies look, mm, each with more than any rounding.
struct LooksCell {
    rows: f32,
    // to others that touch them
    touching: f32,
    // to others that their sensors notice
    sensing: f32,
    // more than any rounding
    margin: f32,
}

fn squares_of(world: u32) -> SquaresCell {
    let cell = numbers(world, SQUARES_CELL);
    return SquaresCell(cell.x, cell.y, cell.z, cell.w);
}

fn looks_of(world: u32) -> LooksCell {
    let cell = numbers(world, SQUARES_CELL + 1u);
    return LooksCell(cell.x, cell.y, cell.z, cell.w);
}

// Column and row of the square at a place; beyond the squares those of the nearest.
fn square_at(world: u32, at: vec2<f32>) -> vec2<u32> {
    let squares = squares_of(world);
    let column = clamp((at.x - squares.x) * squares.per_mm, 0.0f, squares.columns - 1.0f);
    let row = clamp((at.y - squares.y) * squares.per_mm, 0.0f, looks_of(world).rows - 1.0f);
    return vec2<u32>(u32(column), u32(row));
}

fn square_number(world: u32, square: vec2<u32>) -> u32 {
    return min(square.y * u32(squares_of(world).columns) + square.x, MOST_SQUARES - 1u);
}

// Lists the bodies by squares, in each by their numbers.
fn list_bodies(episode: Episode) {
    let world = episode.world;
    let squares = min(u32(squares_of(world).columns) * u32(looks_of(world).rows), MOST_SQUARES);
    let lists = episode.world_words;
    let count = body_count(world);
    for (var square = 0u; square < squares; square++) {
        put_word(lists, WORLD_SQUARES + square, 0u);
    }
    for (var body = 0u; body < count; body++) {
        let words = member_at(episode, body);
        let at = place_in(words, MEMBER_X);
        put_place(words, MEMBER_LISTED, at);
        let square = WORLD_SQUARES + square_number(world, square_at(world, at));
        put_word(lists, square, word(lists, square) + 1u);
    }
    // where each list ends; filled from its end on, each is where it begins
    var end = 0u;
    for (var square = 0u; square < squares; square++) {
        end += word(lists, WORLD_SQUARES + square);
        put_word(lists, WORLD_SQUARES + square, end);
    }
    put_word(lists, WORLD_SQUARES + squares, end);
    for (var body = 0u; body < count; body++) {
        let last = count - 1u - body;
        let at = place_in(member_at(episode, last), MEMBER_X);
        let square = WORLD_SQUARES + square_number(world, square_at(world, at));
        let entry = word(lists, square) - 1u;
        put_word(lists, square, entry);
        put_word(lists, WORLD_LISTED + min(entry, GREATEST_MEMBERS - 1u), last);
    }
}

// A search among the bodies around a place: row after row of squares.
struct Search {
    // the first row's first square, and the columns after it
    from_square: u32,
    columns: u32,
    rows: u32,
    // the next entry of this row, and where the row ends
    entry: u32,
    end: u32,
    // the body of this turn, if it has one
    body: u32,
    is_found: bool,
    is_over: bool,
}

// Turns of a search, at most.
const SEARCH_TURNS: u32 = GREATEST_MEMBERS + MOST_ROWS + 1u;

// Begins a search among all bodies that were less than `reach` mm from a place, along x and along y.
fn search_around(episode: Episode, at: vec2<f32>, reach: f32) -> Search {
    let world = episode.world;
    let low = square_at(world, vec2<f32>(at.x - reach, at.y - reach));
    let high = square_at(world, vec2<f32>(at.x + reach, at.y + reach));
    return Search(square_number(world, low), high.x - low.x, high.y - low.y + 1u, 0u, 0u, 0u, false, false);
}

// A turn of a search: it finds a body, unless its row has none or it is over.
fn search_on(episode: Episode, before: Search) -> Search {
    var search = before;
    let lists = episode.world_words;
    if ((search.entry == search.end) & (search.rows > 0u)) {
        let first = min(search.from_square, MOST_SQUARES - 1u);
        search.entry = word(lists, WORLD_SQUARES + first);
        search.end = word(lists, WORLD_SQUARES + min(first + search.columns + 1u, MOST_SQUARES));
        search.from_square = first + u32(squares_of(episode.world).columns);
        search.rows -= 1u;
    }
    search.is_found = search.entry < search.end;
    search.is_over = !search.is_found & (search.rows == 0u);
    if (search.is_found) {
        search.body = word(lists, WORLD_LISTED + min(search.entry, GREATEST_MEMBERS - 1u));
        search.entry++;
    }
    return search;
}

fn search_for_sensors(episode: Episode, at: vec2<f32>) -> Search {
    return search_around(episode, at, looks_of(episode.world).sensing);
}

// The farthest that any body is from where it is listed, along x or along y, mm.
fn farthest_shift(episode: Episode, field: u32) -> f32 {
    var farthest = 0.0f;
    for (var body = 0u; body < body_count(episode.world); body++) {
        let words = member_at(episode, body);
        let at = place_in(words, field);
        let listed = place_in(words, MEMBER_LISTED);
        farthest = max(farthest, max(abs(at.x - listed.x), abs(at.y - listed.y)));
    }
    return farthest;
}

fn reach_to_touching(episode: Episode) -> f32 {
    return looks_of(episode.world).touching + farthest_shift(episode, MEMBER_GOAL);
}

// Here all others give way to a body, also those before it: again each to the others in the order of their numbers.
fn push_others(episode: Episode, of_robots: Apart, count: u32, member: u32, reach: f32) -> bool {
    let at = place_in(member_at(episode, member), MEMBER_BEFORE);
    var pushed = false;
    var search = search_around(episode, at, reach);
    for (var turn = 0u; turn < SEARCH_TURNS; turn++) {
        search = search_on(episode, search);
        if (search.is_over) {
            break;
        }
        if (search.is_found & (search.body != member)) {
            let another = member_at(episode, search.body);
            let beside = place_in(another, MEMBER_BEFORE);
            let away = vec2<f32>(beside.x - at.x, beside.y - at.y);
            let squared = squared_length(away);
            if (overlapped(episode, of_robots, squared, member, search.body)) {
                let shares = shares_of_way(episode, of_robots, squared, min(member, search.body), max(member, search.body));
                let share = select(shares.x, -shares.y, search.body > member);
                let gone = place_in(another, MEMBER_GOAL);
                put_place(another, MEMBER_GOAL, vec2<f32>(gone.x + share * away.x, gone.y + share * away.y));
                pushed = true;
            }
        }
    }
    return pushed;
}

fn is_pressed(episode: Episode, of_robots: Apart, count: u32, member: u32, reach: f32) -> bool {
    let at = place_in(member_at(episode, member), MEMBER_GOAL);
    var pressed = false;
    var search = search_around(episode, at, reach);
    for (var turn = 0u; turn < SEARCH_TURNS; turn++) {
        search = search_on(episode, search);
        if (search.is_over) {
            break;
        }
        if (search.is_found & (search.body != member)) {
            pressed = pressed | is_in_way(episode, of_robots, member, at, search.body);
        }
    }
    return pressed;
}

fn queue_those_in_way(episode: Episode, of_robots: Apart, queued: u32, reach: f32) {
    var head = 0u;
    var tail = queued;
    var returning = 0u;
    var start = vec2<f32>(0.0f, 0.0f);
    var search = Search();
    search.is_over = true;
    for (var turn = 0u; turn < SEARCH_TURNS * GREATEST_MEMBERS; turn++) {
        if (search.is_over) {
            if (head == tail) {
                break;
            }
            returning = word(member_at(episode, head), MEMBER_QUEUE);
            start = place_in(member_at(episode, returning), MEMBER_X);
            search = search_around(episode, start, reach);
            head++;
        }
        search = search_on(episode, search);
        if (search.is_found) {
            let another = member_at(episode, search.body);
            if (is_in_way(episode, of_robots, returning, start, search.body) & (word(another, MEMBER_MET) == 0u)) {
                put_word(another, MEMBER_MET, 1u);
                put_word(member_at(episode, tail), MEMBER_QUEUE, search.body);
                tail++;
            }
        }
    }
}

// mm; links of clusters that are longer link all.
const FARTHEST_LINK: f32 = 0x1p20f;

fn clusters_of(episode: Episode, begin: u32, bodies: u32, reach: f32) -> Clusters {
    let count = min(bodies, GREATEST_MEMBERS);
    for (var member = 0u; member < count; member++) {
        put_word(member_at(episode, begin + member), MEMBER_MET, 0u);
    }
    let linked = select(FARTHEST_LINK, abs(reach), abs(reach) < FARTHEST_LINK);
    let farthest = linked + farthest_shift(episode, MEMBER_X) + looks_of(episode.world).margin;
    // Each turn of the loop begins a cluster, or looks around a body of the one that is being followed.
    var found = Clusters(0u, 0u);
    var first = 0u;
    var head = 0u;
    var tail = 0u;
    var size = 0u;
    var here = vec2<f32>(0.0f, 0.0f);
    var search = Search();
    search.is_over = true;
    for (var turn = 0u; turn < SEARCH_TURNS * GREATEST_MEMBERS; turn++) {
        if (search.is_over & (head < tail)) {
            here = place_in(member_at(episode, word(member_at(episode, begin + head), MEMBER_QUEUE)), MEMBER_X);
            search = search_around(episode, here, farthest);
            head++;
        }
        if (search.is_over) {
            if (first == count) {
                break;
            }
            let at = member_at(episode, begin + first);
            if (word(at, MEMBER_MET) == 0u) {
                put_word(at, MEMBER_MET, 1u);
                put_word(member_at(episode, begin + tail), MEMBER_QUEUE, begin + first);
                tail++;
                found.count++;
                size = 1u;
            }
            first++;
        } else {
            search = search_on(episode, search);
            if (search.is_found & (search.body >= begin) & (search.body < begin + count)) {
                let at = member_at(episode, search.body);
                let there = place_in(at, MEMBER_X);
                let squared = squared_length(vec2<f32>(there.x - here.x, there.y - here.y));
                if ((word(at, MEMBER_MET) == 0u) & (squared < reach * reach)) {
                    put_word(at, MEMBER_MET, 1u);
                    put_word(member_at(episode, begin + tail), MEMBER_QUEUE, search.body);
                    tail++;
                    size++;
                }
            }
        }
        found.largest = max(found.largest, size);
    }
    return found;
}
