// The food of a single robot's arena with up to 64 items, for arenas of more robots than the paper's. `lib/food_few` is shorter
// where eight items are enough.

const FOOD_ROOM: u32 = 64u;

struct Food {
    a: Eight,
    b: Eight,
    c: Eight,
    d: Eight,
    e: Eight,
    f: Eight,
    g: Eight,
    h: Eight,
}

fn no_food() -> Food {
    let none = no_eight();
    return Food(none, none, none, none, none, none, none, none);
}

fn food_kept(food: Food) -> Food {
    return Food(
        eight_kept(food.a), eight_kept(food.b), eight_kept(food.c), eight_kept(food.d),
        eight_kept(food.e), eight_kept(food.f), eight_kept(food.g), eight_kept(food.h),
    );
}

// Differences below 0 wrap around, so that the item is not among those eight.
fn with_item(food: Food, item: u32, place: vec2<f32>) -> Food {
    return Food(
        eight_with(food.a, item, place), eight_with(food.b, item - 8u, place),
        eight_with(food.c, item - 16u, place), eight_with(food.d, item - 24u, place),
        eight_with(food.e, item - 32u, place), eight_with(food.f, item - 40u, place),
        eight_with(food.g, item - 48u, place), eight_with(food.h, item - 56u, place),
    );
}

// The first item within reach of a place, or GREATEST_ITEMS.
fn item_at(world: u32, food: Food, at: vec2<f32>) -> u32 {
    let reach = nest_of(world).squared_reach;
    let first = min(
        min(eight_reached(food.a, 0u, at, reach), eight_reached(food.b, 8u, at, reach)),
        min(eight_reached(food.c, 16u, at, reach), eight_reached(food.d, 24u, at, reach)),
    );
    let last = min(
        min(eight_reached(food.e, 32u, at, reach), eight_reached(food.f, 40u, at, reach)),
        min(eight_reached(food.g, 48u, at, reach), eight_reached(food.h, 56u, at, reach)),
    );
    return min(first, last);
}

// Distance of the nearest item from a place, mm.
fn nearest_food(food: Food, at: vec2<f32>) -> f32 {
    let first = min(
        min(eight_nearest(food.a, at), eight_nearest(food.b, at)), min(eight_nearest(food.c, at), eight_nearest(food.d, at)),
    );
    let last = min(
        min(eight_nearest(food.e, at), eight_nearest(food.f, at)), min(eight_nearest(food.g, at), eight_nearest(food.h, at)),
    );
    return root(min(first, last));
}
