// Arenas of many objects: a grid says which ones may matter at a place. Its declarations replace those of
// lib/geometry.wgsl with the same names. Results are the same bits: objects outside of a list are farther away than anything that a
// body or a sensor there notices. `NEAR_CELL` is generated: where the grid's head is, which its squares follow.

// As GREATEST_OBJECTS in src/world/arena.rs has it.
const GREATEST_SHAPES: u32 = 4096u;

fn near_head(world: u32) -> u32 {
    return worlds[world].numbers + NEAR_CELL;
}

fn near_first(world: u32, at: vec2<f32>) -> u32 {
    return square_list(near_head(world), near_head(world) + 2u, at).x;
}

fn near_count(world: u32, at: vec2<f32>) -> u32 {
    return square_count(near_head(world), near_head(world) + 2u, at);
}

fn near_shape(world: u32, entry: u32) -> u32 {
    return worlds[world].first_shape + min(square_entry(near_head(world), entry), shape_count(world) - 1u);
}
