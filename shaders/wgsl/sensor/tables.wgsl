// An object as the sampled sensors of a parametric robot see it. Their tables have any number of sensors, in planes of eight: a point
// of view has PLANES planes, one after the other, and each is laid out as the one that sensor/sampled.wgsl looks up.

// An object in a layer.
struct Sighted {
    in_reach: bool,
    // from the robot's centre to the object's axis, mm
    to: vec2<f32>,
    // distance at which it touches the robot, mm
    contact: f32,
    // first cell of its table, of its point of view
    table: u32,
}

// An object from a robot that senses from the place `at`. Beyond `reach` mm from the rim tables have no rows.
fn sighted(world: u32, shape: u32, pose: vec3<f32>, at: vec2<f32>, reach: f32) -> Sighted {
    var to = toward(shape, at);
    var contact = shapes[shape].contact;
    let farthest = contact + reach;
    let near = squared_length(to) < farthest * farthest;
    var seen_from = at;
    if (worlds[world].walk_range > 0.0f) {
        // A displacement through an object keeps its bearing and stands at the nearest distance, as in sensor/sampled.wgsl.
        let unshifted = toward(shape, vec2<f32>(pose.x, pose.y));
        let facing = unshifted.x * to.x + unshifted.y * to.y;
        var crossed = facing < 0.0f;
        if (shapes[shape].kind == BLOCK) {
            crossed = facing <= 0.0f;
            to.x = select(to.x, -unshifted.x, crossed);
            to.y = select(to.y, -unshifted.y, crossed);
            seen_from.x = select(seen_from.x, pose.x, crossed);
            seen_from.y = select(seen_from.y, pose.y, crossed);
        }
        to.x = select(to.x, -to.x, crossed);
        to.y = select(to.y, -to.y, crossed);
        contact = select(contact, 0x1p20f, crossed);
    }
    var table = shapes[shape].table;
    if (near & (shapes[shape].kind == BLOCK)) {
        let view = view_from(within(shape, seen_from), shapes[shape].views);
        table += view * PLANES * worlds[world].rows * worlds[world].bearings;
    }
    return Sighted(near, to, contact, table);
}
