// Arenas of many objects: a grid says which ones may matter at a place. Its declarations replace those of
// lib/geometry.wgsl with the same names. Results are the same bits: objects outside of a list are farther away than anything that a
// body or a sensor there notices. `NEAR_CELL` is generated: where the grid begins in `tables`, as src/world/near.rs writes it. A cell
// with the lower left corner, squares per mm, and the first cell of lists; one with the numbers of columns and rows, and the length
// of the longest list, by which loops are bounded; then for each
// square the first entry of its list and the number of entries, two squares a cell; then the lists, four entries a cell.

// As GREATEST_OBJECTS in src/world/arena.rs has it.
const GREATEST_SHAPES: u32 = 4096u;
// Most entries of a square's list.
const GREATEST_NEAR: u32 = 512u;

fn near_words(world: u32, cell: u32) -> vec4<u32> {
    return tables[worlds[world].numbers + NEAR_CELL + cell];
}

// A square's first entry and number of entries; none beyond the grid, where nothing is near.
fn near_list(world: u32, at: vec2<f32>) -> vec2<u32> {
    let grid = numbers(world, NEAR_CELL);
    let sides = near_words(world, 1u);
    let column = (at.x - grid.x) * grid.z;
    let row = (at.y - grid.y) * grid.z;
    let is_within = (column >= 0.0f) & (row >= 0.0f) & (column < f32(sides.x)) & (row < f32(sides.y));
    let square = select(0u, u32(clamp(row, 0.0f, f32(sides.y - 1u))) * sides.x + u32(clamp(column, 0.0f, f32(sides.x - 1u))), is_within);
    let pair = near_words(world, 2u + square / 2u);
    let list = select(pair.xy, pair.zw, vec2<bool>((square & 1u) == 1u));
    return select(vec2<u32>(0u, 0u), list, vec2<bool>(is_within));
}

fn near_first(world: u32, at: vec2<f32>) -> u32 {
    return near_list(world, at).x;
}

fn near_count(world: u32, at: vec2<f32>) -> u32 {
    return min(min(near_list(world, at).y, near_words(world, 1u).z), GREATEST_NEAR);
}

fn near_shape(world: u32, entry: u32) -> u32 {
    let words = near_words(world, u32(numbers(world, NEAR_CELL).w) + entry / 4u);
    let low = select(words.x, words.y, (entry & 1u) == 1u);
    let high = select(words.z, words.w, (entry & 1u) == 1u);
    return worlds[world].first_shape + min(select(low, high, (entry & 2u) == 2u), shape_count(world) - 1u);
}
