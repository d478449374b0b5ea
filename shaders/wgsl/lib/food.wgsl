// Where food lies. What is taken appears anew elsewhere, uniform in the arena outside the nest.

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

// Where an item lies as an episode begins. Items that robots share and that are taken in step 0 appear at places of blocks from
// 16 to 79, see `task/shared_foraging`.
fn first_place(episode: Episode, item: u32) -> vec2<f32> {
    return place_of_food(episode, 0u, 64u * (item + select(128u, 1u, item < 8u)));
}
