// Food that all robots of a world share. An item goes to the nearest robot that reaches it, of equally near ones to the
// first; a robot that reaches several asks for the first. Fitness is equation 1 of O'Dowd, Studley and Winfield (2014),
// each robot's over its own interval.

const NOBODY: u32 = 0xffffu;

// Who gets each of eight items, and how near the nearest is.
struct Claims {
    first: vec4<u32>,
    last: vec4<u32>,
    first_squared: vec4<f32>,
    last_squared: vec4<f32>,
}

fn no_claims() -> Claims {
    return Claims(vec4<u32>(NOBODY), vec4<u32>(NOBODY), vec4<f32>(0x1p40f), vec4<f32>(0x1p40f));
}

// A robot that carries nothing asks for the item that it reaches.
fn claimed(before: Claims, world: u32, robot: u32, at: vec2<f32>, food: Food) -> Claims {
    var claims = before;
    let item = item_at(world, food, at);
    if (item < GREATEST_ITEMS) {
        let far = squares_from(food, at);
        let gets_first = (vec4<u32>(item) == vec4<u32>(0u, 1u, 2u, 3u)) & (far.first < claims.first_squared);
        let gets_last = (vec4<u32>(item) == vec4<u32>(4u, 5u, 6u, 7u)) & (far.last < claims.last_squared);
        claims.first = select(claims.first, vec4<u32>(robot), gets_first);
        claims.last = select(claims.last, vec4<u32>(robot), gets_last);
        claims.first_squared = select(claims.first_squared, far.first, gets_first);
        claims.last_squared = select(claims.last_squared, far.last, gets_last);
    }
    return claims;
}

fn gets_any(claims: Claims, robot: u32) -> bool {
    let first = (claims.first.x == robot) | (claims.first.y == robot) | (claims.first.z == robot) | (claims.first.w == robot);
    let last = (claims.last.x == robot) | (claims.last.y == robot) | (claims.last.z == robot) | (claims.last.w == robot);
    return first | last;
}

// Who gets an item.
fn owner(claims: Claims, item: u32) -> u32 {
    let first = select(select(select(claims.first.w, claims.first.z, item == 2u), claims.first.y, item == 1u), claims.first.x, item == 0u);
    let last = select(select(select(claims.last.w, claims.last.z, item == 6u), claims.last.y, item == 5u), claims.last.x, item == 4u);
    return select(last, first, item < 4u);
}

fn load_food(base: u32) -> Food {
    return Food(
        vec4<f32>(number(base, ITEM_X), number(base, ITEM_X + 1u), number(base, ITEM_X + 2u), number(base, ITEM_X + 3u)),
        vec4<f32>(number(base, ITEM_X + 4u), number(base, ITEM_X + 5u), number(base, ITEM_X + 6u), number(base, ITEM_X + 7u)),
        vec4<f32>(number(base, ITEM_Y), number(base, ITEM_Y + 1u), number(base, ITEM_Y + 2u), number(base, ITEM_Y + 3u)),
        vec4<f32>(number(base, ITEM_Y + 4u), number(base, ITEM_Y + 5u), number(base, ITEM_Y + 6u), number(base, ITEM_Y + 7u)),
    );
}

fn save_food(base: u32, food: Food) {
    put_four(base, ITEM_X, food.x_first);
    put_four(base, ITEM_X + 4u, food.x_last);
    put_four(base, ITEM_Y, food.y_first);
    put_four(base, ITEM_Y + 4u, food.y_last);
}

// After all have moved: who takes what, what is brought, and where food appears anew.
fn share_food(episode: Episode, base: u32, step: u32) {
    let world = episode.world;
    let food = load_food(base);
    let nest = nest_of(world);
    let arena = arena_of(world);
    let unheard = delays_of(world).tracking_loss;
    let count = robots(world);
    var claims = no_claims();
    for (var robot = 0u; robot < count; robot++) {
        let robot_words = robot_at(base, robot);
        let at = vec2<f32>(number(robot_words, X), number(robot_words, Y));
        // The tracking tells a robot where it is, mostly.
        let told = unit(random_words(robot_key(robot_words), STREAM_ENVIRONMENT, step, 0u).x) >= unheard;
        if (told & (word(robot_words, BEHAVIOUR) != OFF)) {
            if (word(robot_words, CARRIES) == 0u) {
                claims = claimed(claims, world, robot, at, food);
            } else if (squared_length(vec2<f32>(at.x - nest.x, at.y - nest.y)) < nest.squared_radius) {
                let seconds = f32(step + 1u - word(robot_words, SINCE)) * arena.cycle;
                put(robot_words, EARNED, number(robot_words, EARNED) + max(times_of(world).limit - seconds, 0.0f));
                state[robot_words + CARRIES * LANES] = 0u;
                state[robot_words + BROUGHT * LANES] = word(robot_words, BROUGHT) + 1u;
                state[base + HARVESTED * LANES] = word(base, HARVESTED) + 1u;
            }
        }
    }
    let nearest = vec4<f32>(min(claims.first_squared, claims.last_squared));
    if (min(min(nearest.x, nearest.y), min(nearest.z, nearest.w)) < 0x1p40f) {
        for (var robot = 0u; robot < count; robot++) {
            if (gets_any(claims, robot)) {
                state[robot_at(base, robot) + CARRIES * LANES] = 1u;
            }
        }
        var left = food;
        for (var item = 0u; item < GREATEST_ITEMS; item++) {
            if (owner(claims, item) != NOBODY) {
                // The blocks below are those of the food that an episode begins with.
                left = with_item(left, item, place_of_food(episode, step, 64u * (item + 16u)));
            }
        }
        save_food(base, left);
    }
}
