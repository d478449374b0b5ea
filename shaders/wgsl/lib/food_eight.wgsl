// Eight items of food, or fewer, in variables: for kernels of a single robot. Places that no item has are out of reach.

struct Eight {
    x_first: vec4<f32>,
    x_last: vec4<f32>,
    y_first: vec4<f32>,
    y_last: vec4<f32>,
}

fn no_eight() -> Eight {
    let far = vec4<f32>(0x1p17f);
    return Eight(far, far, far, far);
}

fn stored_all(v: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(stored(v.x), stored(v.y), stored(v.z), stored(v.w));
}

fn eight_kept(eight: Eight) -> Eight {
    return Eight(stored_all(eight.x_first), stored_all(eight.x_last), stored_all(eight.y_first), stored_all(eight.y_last));
}

// With another place of one of them; all other numbers change nothing.
fn eight_with(eight: Eight, item: u32, place: vec2<f32>) -> Eight {
    let first = vec4<u32>(item) == vec4<u32>(0u, 1u, 2u, 3u);
    let last = vec4<u32>(item) == vec4<u32>(4u, 5u, 6u, 7u);
    return Eight(
        select(eight.x_first, vec4<f32>(place.x), first), select(eight.x_last, vec4<f32>(place.x), last),
        select(eight.y_first, vec4<f32>(place.y), first), select(eight.y_last, vec4<f32>(place.y), last),
    );
}

// The squared distances of eight items from a place.
struct Squares {
    first: vec4<f32>,
    last: vec4<f32>,
}

fn squares_from(eight: Eight, at: vec2<f32>) -> Squares {
    let x_first = eight.x_first - at.x;
    let y_first = eight.y_first - at.y;
    let x_last = eight.x_last - at.x;
    let y_last = eight.y_last - at.y;
    return Squares(x_first * x_first + y_first * y_first, x_last * x_last + y_last * y_last);
}

// The first item nearer than `reach`, squared, or GREATEST_ITEMS; `before` items are in other eights before.
fn eight_reached(eight: Eight, before: u32, at: vec2<f32>, reach: f32) -> u32 {
    let far = squares_from(eight, at);
    var item = GREATEST_ITEMS;
    item = select(item, before + 7u, far.last.w < reach);
    item = select(item, before + 6u, far.last.z < reach);
    item = select(item, before + 5u, far.last.y < reach);
    item = select(item, before + 4u, far.last.x < reach);
    item = select(item, before + 3u, far.first.w < reach);
    item = select(item, before + 2u, far.first.z < reach);
    item = select(item, before + 1u, far.first.y < reach);
    return select(item, before, far.first.x < reach);
}

// The least squared distance from a place.
fn eight_nearest(eight: Eight, at: vec2<f32>) -> f32 {
    let far = squares_from(eight, at);
    let least = min(far.first, far.last);
    return min(min(least.x, least.y), min(least.z, least.w));
}

// The food that an episode begins with.
fn first_food(episode: Episode) -> Food {
    var food = no_food();
    let items = min(u32(arena_of(episode.world).items), FOOD_ROOM);
    for (var item = 0u; item < items; item++) {
        food = with_item(food, item, first_place(episode, item));
    }
    return food;
}
