// The food of a single robot's arena with up to eight items, as in the paper.

const FOOD_ROOM: u32 = 8u;

struct Food {
    items: Eight,
}

fn no_food() -> Food {
    return Food(no_eight());
}

fn food_kept(food: Food) -> Food {
    return Food(eight_kept(food.items));
}

fn with_item(food: Food, item: u32, place: vec2<f32>) -> Food {
    return Food(eight_with(food.items, item, place));
}

// The first item within reach of a place, or GREATEST_ITEMS.
fn item_at(world: u32, food: Food, at: vec2<f32>) -> u32 {
    return eight_reached(food.items, 0u, at, nest_of(world).squared_reach);
}

// Distance of the nearest item from a place, mm.
fn nearest_food(food: Food, at: vec2<f32>) -> f32 {
    return root(eight_nearest(food.items, at));
}
