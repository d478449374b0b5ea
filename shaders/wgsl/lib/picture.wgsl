// Floors with a picture: grey cells in `tables`, as src/world/picture.rs writes them, sixteen to a cell of the tables.

// The grey of a picture at a place, or `beyond` outside of it. Its head begins at this cell: the lower left corner and the cells per
// mm; the numbers of columns and rows, the first of the tables' cells with greys, and what a grey of 1 reads.
fn picture_grey(head: u32, place: vec2<f32>, beyond: f32) -> f32 {
    let field = tables[head];
    let size = tables[head + 1u];
    // A place that is no normal number away from an edge is on it, on every device.
    let column = flushed(flushed(place.x - bitcast<f32>(field.x)) * bitcast<f32>(field.z));
    let row = flushed(flushed(place.y - bitcast<f32>(field.y)) * bitcast<f32>(field.w));
    let is_within = (column >= 0.0f) & (row >= 0.0f) & (column < f32(size.x)) & (row < f32(size.y));
    let across = u32(clamp(column, 0.0f, f32(size.x - 1u)));
    let up = u32(clamp(row, 0.0f, f32(size.y - 1u)));
    let index = select(0u, up * size.x + across, is_within);
    let words = tables[size.z + index / 16u];
    let is_odd = ((index / 4u) & 1u) == 1u;
    let low = select(words.x, words.y, is_odd);
    let high = select(words.z, words.w, is_odd);
    let word = select(low, high, ((index / 8u) & 1u) == 1u);
    let grey = f32((word >> (8u * (index & 3u))) & 255u);
    return select(beyond, min(grey * bitcast<f32>(size.w), 1.0f), is_within);
}
