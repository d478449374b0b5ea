// Every object of an arena is a thick segment: a wall has no thickness, a round obstacle has no length.

// From a point to the nearest point of a shape's axis, in mm.
fn toward(shape: u32, at: vec2<f32>) -> vec2<f32> {
    let from_x = at.x - shapes[shape].x;
    let from_y = at.y - shapes[shape].y;
    if (shapes[shape].round != 0u) {
        return vec2<f32>(-from_x, -from_y);
    }
    let along = clamp(from_x * shapes[shape].scaled_x + from_y * shapes[shape].scaled_y, 0.0f, 1.0f);
    return vec2<f32>(along * shapes[shape].length_x - from_x, along * shapes[shape].length_y - from_y);
}

fn squared_length(v: vec2<f32>) -> f32 {
    return v.x * v.x + v.y * v.y;
}

// Whether a robot's body that stands there touches an object of its world.
fn touches(world: u32, at: vec2<f32>) -> bool {
    let first = worlds[world].first_shape;
    let end = first + worlds[world].shapes;
    var hit = false;
    for (var shape = first; shape < end; shape++) {
        hit = hit | (squared_length(toward(shape, at)) < shapes[shape].contact_squared);
    }
    return hit;
}
