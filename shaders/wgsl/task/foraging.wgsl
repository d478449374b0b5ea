// Food is taken where it lies and brought to the nest. Equation 1 of O'Dowd, Studley and Winfield (2014): F is the sum
// over all food brought, of the remaining time.

// What a cycle brings.
struct Harvest {
    food: Food,
    carries: bool,
    earned: f32,
}

// The food that a robot takes or brings at the end of a cycle's way.
fn harvest(episode: Episode, step: u32, at: vec2<f32>, food: Food, carries: bool) -> Harvest {
    let nest = nest_of(episode.world);
    var next = Harvest(food, carries, 0.0f);
    if (carries) {
        if (squared_length(vec2<f32>(at.x - nest.x, at.y - nest.y)) < nest.squared_radius) {
            let seconds = f32(step + 1u) * arena_of(episode.world).cycle;
            next.earned = max(times_of(episode.world).limit - seconds, 0.0f);
            next.carries = false;
        }
        return next;
    }
    let item = item_at(episode.world, food, at);
    if (item < GREATEST_ITEMS) {
        next.food = with_item(food, item, place_of_food(episode, step, 0u));
        next.carries = true;
    }
    return next;
}
