// Functions of the world for users' parts, and the limit of their results.
// docs/extend.md lists what they may call.

// Four random numbers in [0, 1) of a stream at a cycle. Each number from 0 to 65535 gives others.
fn random(episode: Episode, stream: u32, step: u32, number: u32) -> vec4<f32> {
    return units(random_words(episode.key, stream, step, number));
}

// Whether a robot's body touches something where its centre is at a point, mm.
fn blocked(episode: Episode, at: vec2<f32>) -> bool {
    return touches(episode.world, at);
}

// Distance in mm from a point to the nearest object along a ray, up to 100 m. The heading is in turns. Without an object,
// `most`, which is also the maximum distance that is returned.
fn distance_along(episode: Episode, start: vec2<f32>, heading: f32, most: f32) -> f32 {
    return ray_in_world(episode.world, start, heading, most);
}

// The same in a world.
fn ray_in_world(world: u32, start: vec2<f32>, heading: f32, most: f32) -> f32 {
    let ahead = cosine_sine(heading);
    let first = worlds[world].first_shape;
    let end = first + shape_count(world);
    var nearest = most;
    for (var shape = first; shape < end; shape++) {
        nearest = min(nearest, ray_to_shape(shape, start, ahead, most));
    }
    return nearest;
}

// Distance along a ray to one object; `most` if the ray misses it.
fn ray_to_shape(shape: u32, start: vec2<f32>, ahead: vec2<f32>, most: f32) -> f32 {
    if (shapes[shape].kind == ROUND) {
        return ray_to_round(shape, start, ahead, most);
    }
    if (shapes[shape].kind == BLOCK) {
        return ray_to_block(shape, start, ahead, most);
    }
    return ray_to_wall(shape, start, ahead, most);
}

// The same for a round obstacle, a block, and a wall.
fn ray_to_round(shape: u32, start: vec2<f32>, ahead: vec2<f32>, most: f32) -> f32 {
    let to = vec2<f32>(shapes[shape].x - start.x, shapes[shape].y - start.y);
    if (squared_length(to) < shapes[shape].radius * shapes[shape].radius) {
        return 0.0f;
    }
    let along = to.x * ahead.x + to.y * ahead.y;
    let aside = to.x * ahead.y - to.y * ahead.x;
    let half = shapes[shape].radius * shapes[shape].radius - aside * aside;
    if ((half > 0.0f) & (along > 0.0f)) {
        return max(along - root(half), 0.0f);
    }
    return most;
}

fn ray_to_block(shape: u32, start: vec2<f32>, ahead: vec2<f32>, most: f32) -> f32 {
    let inner = within(shape, start);
    let axis = vec2<f32>(shapes[shape].unit_x, shapes[shape].unit_y);
    let inner_ahead = vec2<f32>(ahead.x * axis.x + ahead.y * axis.y, ahead.y * axis.x - ahead.x * axis.y);
    let half = vec2<f32>(shapes[shape].half_length, shapes[shape].half_width);
    return to_block(inner, inner_ahead, half, most);
}

fn ray_to_wall(shape: u32, start: vec2<f32>, ahead: vec2<f32>, most: f32) -> f32 {
    let to = vec2<f32>(shapes[shape].x - start.x, shapes[shape].y - start.y);
    let span = vec2<f32>(shapes[shape].length_x, shapes[shape].length_y);
    return to_wall(to, span, ahead, most);
}

// How far a wall goes beyond its ends for a ray, as a fraction of its length, so that no ray slips through where walls meet.
const PAST_END: f32 = 0x1p-20f;

// Distance along a ray to a wall that starts at `to` and spans `span`; `most` if the ray misses it.
fn to_wall(to: vec2<f32>, span: vec2<f32>, ahead: vec2<f32>, most: f32) -> f32 {
    let across = ahead.x * span.y - ahead.y * span.x;
    let crosses = abs(across) >= 0x1p-20f;
    let inverse = reciprocal(select(1.0f, across, crosses));
    let distance = (to.x * span.y - to.y * span.x) * inverse;
    let share = (to.x * ahead.y - to.y * ahead.x) * inverse;
    return select(most, distance, crosses & (distance >= 0.0f) & (share >= -PAST_END) & (share <= 1.0f + PAST_END));
}

// Distance along a ray to a block from a point given in the block's own coordinates; 0 from inside it, `most` if the ray
// misses it.
fn to_block(start: vec2<f32>, ahead: vec2<f32>, half: vec2<f32>, most: f32) -> f32 {
    let x = within_slab(start.x, ahead.x, half.x);
    let y = within_slab(start.y, ahead.y, half.y);
    let enter = max(max(x.x, y.x), 0.0f);
    let leave = min(x.y, y.y);
    return select(most, enter, enter <= leave);
}

// Distances at which a ray enters and leaves the space between -half and half of one axis.
fn within_slab(start: f32, ahead: f32, half: f32) -> vec2<f32> {
    if (abs(ahead) < 0x1p-20f) {
        return select(vec2<f32>(1.0f, -1.0f), vec2<f32>(-0x1p30f, 0x1p30f), vec2<bool>(abs(start) <= half));
    }
    let inverse = reciprocal(ahead);
    let a = (-half - start) * inverse;
    let b = (half - start) * inverse;
    return vec2<f32>(min(a, b), max(a, b));
}

// A number in a range; 0 for one that is not a number, which devices would convert in different ways.
fn limited(x: f32, low: f32, high: f32) -> f32 {
    let is_no_number = (bitcast<u32>(x) & 0x7fffffffu) > 0x7f800000u;
    return select(clamp(x, low, high), 0.0f, is_no_number);
}

// A number; 0 instead of one so small that its product with a gene might be subnormal.
fn flushed(x: f32) -> f32 {
    return select(0.0f, x, abs(x) >= 0x1p-60f);
}

// The hyperbolic tangent of every x. Absolute error 3.0e-7; exact for 0.
fn hyperbolic_tangent(x: f32) -> f32 {
    return 2.0f * logistic(2.0f * clamp(x, -22.0f, 22.0f)) - 1.0f;
}
