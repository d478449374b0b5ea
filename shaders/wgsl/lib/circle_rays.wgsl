// Rays in an arena whose wall is a circle around the origin.

// Distance in mm from a point within to the wall along a ray; at most `most`. The heading is in turns.
fn ray_in_world(world: u32, start: vec2<f32>, heading: f32, most: f32) -> f32 {
    let ahead = cosine_sine(heading);
    let radius = arena_of(world).radius;
    let along = start.x * ahead.x + start.y * ahead.y;
    let beyond = max(along * along + (radius * radius - squared_length(start)), 0.0f);
    return clamp(root(beyond) - along, 0.0f, most);
}
