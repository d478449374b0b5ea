// What stands in an arena: walls without thickness, round obstacles, and blocks, which are rectangles at any angle.

const WALL: u32 = 0u;
const ROUND: u32 = 1u;
const BLOCK: u32 = 2u;

// Objects of a world: the sums of their sampled readings, each up to 1023, have 16 bits.
const GREATEST_SHAPES: u32 = 64u;

fn shape_count(world: u32) -> u32 {
    return min(worlds[world].shapes, GREATEST_SHAPES);
}

// The objects that a body or a sensor at a place may notice: entries from `near_first` on, `near_count` of them, each for an object.
// Here they are all objects; lib/near.wgsl has them for arenas of many.
fn near_first(world: u32, at: vec2<f32>) -> u32 {
    return worlds[world].first_shape;
}

fn near_count(world: u32, at: vec2<f32>) -> u32 {
    return shape_count(world);
}

fn near_shape(world: u32, entry: u32) -> u32 {
    return entry;
}

// From a point to the nearest point of a wall or a block, or to a round obstacle's centre, in mm.
fn toward(shape: u32, at: vec2<f32>) -> vec2<f32> {
    let from_x = at.x - shapes[shape].x;
    let from_y = at.y - shapes[shape].y;
    if (shapes[shape].kind == ROUND) {
        return vec2<f32>(-from_x, -from_y);
    }
    if (shapes[shape].kind == BLOCK) {
        let inner = within(shape, at);
        let beyond_x = inner.x - clamp(inner.x, -shapes[shape].half_length, shapes[shape].half_length);
        let beyond_y = inner.y - clamp(inner.y, -shapes[shape].half_width, shapes[shape].half_width);
        return vec2<f32>(
            beyond_y * shapes[shape].unit_y - beyond_x * shapes[shape].unit_x,
            -(beyond_x * shapes[shape].unit_y) - beyond_y * shapes[shape].unit_x,
        );
    }
    let along = clamp(from_x * shapes[shape].scaled_x + from_y * shapes[shape].scaled_y, 0.0f, 1.0f);
    return vec2<f32>(along * shapes[shape].length_x - from_x, along * shapes[shape].length_y - from_y);
}

// A point as a block has it: from its centre, along its length and across.
fn within(block: u32, at: vec2<f32>) -> vec2<f32> {
    let from_x = at.x - shapes[block].x;
    let from_y = at.y - shapes[block].y;
    return vec2<f32>(
        from_x * shapes[block].unit_x + from_y * shapes[block].unit_y,
        from_y * shapes[block].unit_x - from_x * shapes[block].unit_y,
    );
}

// The view of an object from a point, given in the object's own coordinates. The views divide half a turn, since a block looks
// the same from behind.
fn view_from(place: vec2<f32>, views: u32) -> u32 {
    let twice = 2.0f * direction_by(place, reciprocal_root(max(squared_length(place), 0x1p-60f)));
    let share = twice - floor(twice);
    return min(u32(share * f32(views)), views - 1u);
}

// Whether a robot's body that stands there touches an object of its world.
fn touches(world: u32, at: vec2<f32>) -> bool {
    let first = near_first(world, at);
    let count = near_count(world, at);
    var hit = false;
    for (var index = 0u; index < count; index++) {
        let shape = near_shape(world, first + index);
        hit = hit | (squared_length(toward(shape, at)) < shapes[shape].contact_squared);
    }
    return hit;
}
