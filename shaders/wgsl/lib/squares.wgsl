// Grids over an arena, which say what is near a place, as src/world/near.rs writes them to `tables`. A grid's head is a cell with the
// lower left corner, squares per mm, and the first cell of lists; and one with the numbers of columns and rows, the length of the
// longest list, by which loops are bounded, and the first cell of squares. Both first cells count from the head. For each square there
// are the first entry of its list and the number of entries, two squares a cell; lists have four entries a cell.

// Most entries of a square's list.
const GREATEST_NEAR: u32 = 512u;

// The first entry and the number of entries for a place; none beyond the grid, where nothing is near. `squares` is their first cell.
fn square_list(head: u32, squares: u32, at: vec2<f32>) -> vec2<u32> {
    let words = tables[head];
    let sides = tables[head + 1u];
    let column = (at.x - bitcast<f32>(words.x)) * bitcast<f32>(words.z);
    let row = (at.y - bitcast<f32>(words.y)) * bitcast<f32>(words.z);
    let is_within = (column >= 0.0f) & (row >= 0.0f) & (column < f32(sides.x)) & (row < f32(sides.y));
    let square = select(0u, u32(clamp(row, 0.0f, f32(sides.y - 1u))) * sides.x + u32(clamp(column, 0.0f, f32(sides.x - 1u))), is_within);
    let pair = tables[squares + square / 2u];
    let list = select(pair.xy, pair.zw, vec2<bool>((square & 1u) == 1u));
    return select(vec2<u32>(0u, 0u), list, vec2<bool>(is_within));
}

// The number of entries for a place, by which loops count.
fn square_count(head: u32, squares: u32, at: vec2<f32>) -> u32 {
    return min(min(square_list(head, squares, at).y, tables[head + 1u].z), GREATEST_NEAR);
}

fn square_entry(head: u32, entry: u32) -> u32 {
    let words = tables[head + u32(bitcast<f32>(tables[head].w)) + entry / 4u];
    let low = select(words.x, words.y, (entry & 1u) == 1u);
    let high = select(words.z, words.w, (entry & 1u) == 1u);
    return select(low, high, (entry & 2u) == 2u);
}
