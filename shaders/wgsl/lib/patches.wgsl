// Floors of many patches: a grid says which ones may be at a place. Its declarations replace those with the same names. Results are the
// same bits: a place is on no patch outside of its list, and lists are in the order of patches. `PATCHES_CELL` is generated: where the
// grid's head is.

// The bit that an entry has for a patch that charges batteries, as src/world/near.rs has it.
const CHARGES: u32 = 0x80000000u;

fn patches_head(world: u32) -> u32 {
    return worlds[world].numbers + PATCHES_CELL;
}

fn patches_squares(world: u32) -> u32 {
    return patches_head(world) + tables[patches_head(world) + 1u].w;
}

fn patches_first(world: u32, at: vec2<f32>) -> u32 {
    return square_list(patches_head(world), patches_squares(world), at).x;
}

fn patches_count(world: u32, at: vec2<f32>) -> u32 {
    return square_count(patches_head(world), patches_squares(world), at);
}

fn patch_of_entry(entry: u32) -> u32 {
    return min(entry & (CHARGES - 1u), PATCH_COUNT - 1u);
}

fn patches_grey(world: u32, place: vec2<f32>, beyond: f32) -> f32 {
    let first = patches_first(world, place);
    let count = patches_count(world, place);
    var grey = beyond;
    for (var index = 0u; index < count; index++) {
        let found = patch_of_entry(square_entry(patches_head(world), first + index));
        let patch_grey = numbers(world, FLOOR_CELL + LIGHT_COUNT + 2u * found + 2u).w;
        grey = select(grey, patch_grey, is_on_patch(world, found, place));
    }
    return grey;
}

// Whether a place is on a patch that charges batteries.
fn is_charged(world: u32, place: vec2<f32>) -> bool {
    let first = patches_first(world, place);
    let count = patches_count(world, place);
    var is_on = false;
    for (var index = 0u; index < count; index++) {
        let entry = square_entry(patches_head(world), first + index);
        is_on = is_on | ((entry >= CHARGES) & is_on_patch(world, patch_of_entry(entry), place));
    }
    return is_on;
}

fn given_grey(episode: Episode, place: vec2<f32>, beyond: f32) -> f32 {
    let first = patches_first(episode.world, place);
    let count = patches_count(episode.world, place);
    var grey = beyond;
    for (var index = 0u; index < count; index++) {
        let found = patch_of_entry(square_entry(patches_head(episode.world), first + index));
        grey = select(grey, arena_patch(episode, found).grey, on_patch(episode, found, place));
    }
    return grey;
}

fn on_other_patch(episode: Episode, patch_number: u32, at: vec2<f32>) -> bool {
    let first = patches_first(episode.world, at);
    let count = patches_count(episode.world, at);
    var is_on = false;
    for (var index = 0u; index < count; index++) {
        let other = patch_of_entry(square_entry(patches_head(episode.world), first + index));
        is_on = is_on | ((other != patch_number) & on_patch(episode, other, at));
    }
    return is_on;
}
