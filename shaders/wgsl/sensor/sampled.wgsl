// Eight sampled proximity sensors: for each class of object a table of readings over the
// object's distance and bearing, and of a block one for each point of view. The readings of all objects in reach are summed and clipped.

// The readings that an object adds: eight 16-bit numbers, the even sensors in the low halves. It lies in the
// direction `to` (mm, from the robot's centre to the object's axis), and touches the robot at `contact` mm.
fn sampled(world: u32, heading: f32, to: vec2<f32>, contact: f32, table: u32) -> vec4<u32> {
    let squared = squared_length(to);
    let inverse = reciprocal_root(max(squared, 0x1p-60f));
    let gap = squared * inverse - contact;
    let row = row_of(world, gap);
    let bearing = bearing_of(world, heading, to, inverse);
    var cell = vec4<u32>(0u);
    if (row < worlds[world].rows) {
        cell = tables[table + row * worlds[world].bearings + bearing];
    }
    return cell;
}

// The readings at a pose without noise, as if the robot were at the place `at`.
//
// The objects come in layers: from nowhere are two of one layer in reach. So it is enough to look up one object
// a layer, which lanes that stand near different objects then do together.
fn sense(world: u32, pose: vec3<f32>, at: vec2<f32>, robot: RobotState) -> Readings {
    let first = worlds[world].first_shape;
    let end = first + shape_count(world);
    var sums = vec4<u32>(0u);
    var in_reach = false;
    var to = vec2<f32>(0.0f, 0.0f);
    var contact = 0.0f;
    var table = 0u;
    for (var shape = first; shape < end; shape++) {
        var candidate = toward(shape, at);
        var touching = shapes[shape].contact;
        let near = squared_length(candidate) < shapes[shape].reach_squared;
        var seen_from = at;
        if (worlds[world].walk_range > 0.0f) {
            // A displacement through a wall keeps the wall's bearing and stands at the nearest distance.
            let unshifted = toward(shape, vec2<f32>(pose.x, pose.y));
            let facing = unshifted.x * candidate.x + unshifted.y * candidate.y;
            var crossed = facing < 0.0f;
            if (shapes[shape].kind == BLOCK) {
                // One into a block or through it also does, where the nearest point may be on any side.
                crossed = facing <= 0.0f;
                candidate.x = select(candidate.x, -unshifted.x, crossed);
                candidate.y = select(candidate.y, -unshifted.y, crossed);
                seen_from.x = select(seen_from.x, pose.x, crossed);
                seen_from.y = select(seen_from.y, pose.y, crossed);
            }
            candidate.x = select(candidate.x, -candidate.x, crossed);
            candidate.y = select(candidate.y, -candidate.y, crossed);
            touching = select(touching, 0x1p20f, crossed);
        }
        if (near) {
            in_reach = true;
            to = candidate;
            contact = touching;
            table = shapes[shape].table;
            if (shapes[shape].kind == BLOCK) {
                let view = view_from(within(shape, seen_from), shapes[shape].views);
                table += view * worlds[world].rows * worlds[world].bearings;
            }
        }
        if (shapes[shape].ends_layer != 0u) {
            if (in_reach) {
                sums += sampled(world, pose.z, to, contact, table);
            }
            in_reach = false;
        }
    }
    let scale = worlds[world].reading_scale;
    let even = sums & vec4<u32>(0xffffu);
    let odd = sums >> vec4<u32>(16u);
    return Readings(
        vec4<f32>(activation(even.x, scale), activation(odd.x, scale), activation(even.y, scale), activation(odd.y, scale)),
        vec4<f32>(activation(even.z, scale), activation(odd.z, scale), activation(even.w, scale), activation(odd.w, scale)),
        SensorReadings(),
    );
}

// The readings with the world's sensor noise: a uniform number is added to each, and the sum clipped.
fn with_noise(episode: Episode, step: u32, readings: Readings) -> Readings {
    let low = worlds[episode.world].sensor_noise_low;
    let span = worlds[episode.world].sensor_noise_span;
    var noisy = readings;
    if (span > 0.0f) {
        let a = units(random_words(episode.key, STREAM_SENSOR, step, 0u));
        let b = units(random_words(episode.key, STREAM_SENSOR, step, 1u));
        noisy.first = clamp(readings.first + (a * span + low), vec4<f32>(0.0f), vec4<f32>(1.0f));
        noisy.last = clamp(readings.last + (b * span + low), vec4<f32>(0.0f), vec4<f32>(1.0f));
    }
    return noisy;
}
