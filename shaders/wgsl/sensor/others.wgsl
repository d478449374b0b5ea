// Sensing of other robots' bodies, which are discs: `to` leads to one's centre.

// Distance along a ray to a disc; `most` if the ray misses it, and 0 from inside it.
fn ray_to_body(to: vec2<f32>, ahead: vec2<f32>, body_squared: f32, most: f32) -> f32 {
    let along = to.x * ahead.x + to.y * ahead.y;
    let aside = to.x * ahead.y - to.y * ahead.x;
    let half = body_squared - aside * aside;
    var distance = most;
    if ((half > 0.0f) & (along > 0.0f)) {
        distance = max(along - root(half), 0.0f);
    }
    return distance;
}

// How far a disc leaves the ray of a sensor free that is elsewhere on the body than it looks, as `free_from_place` has it.
fn body_from_place(
    to: vec2<f32>, outward: vec2<f32>, ahead: vec2<f32>, body_squared: f32, sensor: SensorCell,
) -> f32 {
    if (ray_to_body(to, outward, body_squared, sensor.offset) < sensor.offset) {
        return 0.0f;
    }
    let from_place = vec2<f32>(to.x - sensor.offset * outward.x, to.y - sensor.offset * outward.y);
    return sensor.offset + ray_to_body(from_place, ahead, body_squared, sensor.range);
}

// A bumper's reading of a body whose centre is at this squared distance and bearing; bodies touch where centres are `contact` apart.
fn bumper_on(contact: f32, squared: f32, bearing: f32, sensor: SensorCell, looks: f32) -> f32 {
    let reach = contact + sensor.range;
    let turned = bearing - looks;
    let off = abs(turned - floor(turned + 0.5f));
    return select(0.0f, 1.0f, (squared < reach * reach) & (off <= sensor.share));
}
