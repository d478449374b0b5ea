// Where food lies: up to eight items. What is taken appears anew elsewhere, uniform in the arena outside the nest.

// Where up to eight items lie, mm.
struct Food {
    x_first: vec4<f32>,
    x_last: vec4<f32>,
    y_first: vec4<f32>,
    y_last: vec4<f32>,
}

// A place for an item: uniform in the arena, outside the nest. `block` numbers the draws of this place among all of
// the step.
fn place_of_food(episode: Episode, step: u32, block: u32) -> vec2<f32> {
    let nest = nest_of(episode.world);
    let radius = arena_of(episode.world).radius;
    // Of 64 draws none being good leaves the centre: it happens once in 1e17.
    var place = vec2<f32>(0.0f, 0.0f);
    for (var draw = 0u; draw < 64u; draw++) {
        let u = 2.0f * units(random_words(episode.key, STREAM_ENVIRONMENT, step, block + draw)) - 1.0f;
        let at = vec2<f32>(radius * u.x, radius * u.y);
        let from_nest = vec2<f32>(at.x - nest.x, at.y - nest.y);
        if ((squared_length(at) < radius * radius) & (squared_length(from_nest) >= nest.squared_radius)) {
            place = at;
            break;
        }
    }
    return place;
}

// One of eight, by number.
fn with_item(food: Food, item: u32, place: vec2<f32>) -> Food {
    let first = vec4<u32>(item) == vec4<u32>(0u, 1u, 2u, 3u);
    let last = vec4<u32>(item) == vec4<u32>(4u, 5u, 6u, 7u);
    return Food(
        select(food.x_first, vec4<f32>(place.x), first), select(food.x_last, vec4<f32>(place.x), last),
        select(food.y_first, vec4<f32>(place.y), first), select(food.y_last, vec4<f32>(place.y), last),
    );
}

// The food that an episode begins with; places that no item has are out of reach.
fn first_food(episode: Episode) -> Food {
    let far = vec4<f32>(0x1p17f);
    var food = Food(far, far, far, far);
    let items = min(u32(arena_of(episode.world).items), GREATEST_ITEMS);
    for (var item = 0u; item < items; item++) {
        food = with_item(food, item, place_of_food(episode, 0u, 64u * (item + 1u)));
    }
    return food;
}

// The squared distances of eight items from a place.
struct Squares {
    first: vec4<f32>,
    last: vec4<f32>,
}

fn squares_from(food: Food, at: vec2<f32>) -> Squares {
    let x_first = food.x_first - at.x;
    let y_first = food.y_first - at.y;
    let x_last = food.x_last - at.x;
    let y_last = food.y_last - at.y;
    return Squares(x_first * x_first + y_first * y_first, x_last * x_last + y_last * y_last);
}

// The first item within reach of a place, or GREATEST_ITEMS.
fn item_at(world: u32, food: Food, at: vec2<f32>) -> u32 {
    let reach = nest_of(world).squared_reach;
    let far = squares_from(food, at);
    var item = GREATEST_ITEMS;
    item = select(item, 7u, far.last.w < reach);
    item = select(item, 6u, far.last.z < reach);
    item = select(item, 5u, far.last.y < reach);
    item = select(item, 4u, far.last.x < reach);
    item = select(item, 3u, far.first.w < reach);
    item = select(item, 2u, far.first.z < reach);
    item = select(item, 1u, far.first.y < reach);
    return select(item, 0u, far.first.x < reach);
}
