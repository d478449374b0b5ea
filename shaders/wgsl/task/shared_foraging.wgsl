// Food that all robots of a world share. An item goes to the nearest robot that reaches it, of equally near ones to the
// first; a robot that reaches several asks for the first. Fitness is equation 1 of O'Dowd, Studley and Winfield (2014),
// each robot's over its own interval.

const NOBODY: u32 = 0xffffu;
// The square of a distance that no robot has.
const BEYOND: f32 = 0x1p40f;

// Puts an item somewhere, where nobody asks for it yet.
fn put_item(item_words: u32, place: vec2<f32>) {
    put(item_words, ITEM_X, place.x);
    put(item_words, ITEM_Y, place.y);
    state[item_words + ITEM_OWNER * LANES] = NOBODY;
    put(item_words, ITEM_SQUARED, BEYOND);
}

// The food that a world begins with.
fn begin_food(episode: Episode, base: u32) {
    let count = items(episode.world);
    for (var item = 0u; item < count; item++) {
        put_item(food_at(base, episode.world, item), first_place(episode, item));
    }
}

fn squared_from(item_words: u32, at: vec2<f32>) -> f32 {
    return squared_length(vec2<f32>(number(item_words, ITEM_X) - at.x, number(item_words, ITEM_Y) - at.y));
}

// The first item within reach of a place, or GREATEST_ITEMS.
fn item_at(world: u32, base: u32, at: vec2<f32>) -> u32 {
    let reach = nest_of(world).squared_reach;
    let count = items(world);
    var first = GREATEST_ITEMS;
    for (var item = 0u; item < count; item++) {
        let is_near = squared_from(food_at(base, world, item), at) < reach;
        first = min(first, select(GREATEST_ITEMS, item, is_near));
    }
    return first;
}

// A robot asks for an item: it gets it if it is nearer than those that asked before.
fn ask(item_words: u32, robot: u32, at: vec2<f32>) {
    let squared = squared_from(item_words, at);
    if (squared < number(item_words, ITEM_SQUARED)) {
        put(item_words, ITEM_SQUARED, squared);
        state[item_words + ITEM_OWNER * LANES] = robot;
    }
}

// After all have moved: who takes what, what is brought, and where food appears anew.
fn share_food(episode: Episode, base: u32, step: u32) {
    let world = episode.world;
    let nest = nest_of(world);
    let arena = arena_of(world);
    let unheard = delays_of(world).tracking_loss;
    let count = robots(world);
    var is_asked_for = false;
    for (var robot = 0u; robot < count; robot++) {
        let robot_words = robot_at(base, robot);
        let at = vec2<f32>(number(robot_words, X), number(robot_words, Y));
        // The tracking tells a robot where it is, mostly.
        let told = unit(random_words(robot_key(robot_words), STREAM_ENVIRONMENT, step, 0u).x) >= unheard;
        if (told & (word(robot_words, BEHAVIOUR) != OFF)) {
            if (word(robot_words, CARRIES) == 0u) {
                let item = item_at(world, base, at);
                if (item < GREATEST_ITEMS) {
                    is_asked_for = true;
                    ask(food_at(base, world, item), robot, at);
                }
            } else if (squared_length(vec2<f32>(at.x - nest.x, at.y - nest.y)) < nest.squared_radius) {
                let seconds = f32(step + 1u - word(robot_words, SINCE)) * arena.cycle;
                put(robot_words, EARNED, number(robot_words, EARNED) + max(times_of(world).limit - seconds, 0.0f));
                state[robot_words + CARRIES * LANES] = 0u;
                state[robot_words + BROUGHT * LANES] = word(robot_words, BROUGHT) + 1u;
                state[base + HARVESTED * LANES] = word(base, HARVESTED) + 1u;
            }
        }
    }
    if (is_asked_for) {
        let food = items(world);
        for (var item = 0u; item < food; item++) {
            let item_words = food_at(base, world, item);
            let robot = word(item_words, ITEM_OWNER);
            if (robot != NOBODY) {
                state[robot_at(base, robot) + CARRIES * LANES] = 1u;
                // Blocks of other items than those that begin: see `first_place`.
                put_item(item_words, place_of_food(episode, step, 64u * (item + 16u)));
            }
        }
    }
}
