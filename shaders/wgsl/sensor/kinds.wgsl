// Models of the sensors that an experiment can describe. `looks` is the direction that a sensor faces, in turns, and `place`
// where it is.

// Sensors have two cells each, of which the second has the bearing of those that are elsewhere on the body than they look. After
// them come FLOOR_CELL, a cell with the floor's grey; LIGHT_COUNT lights of a cell each, x, y and brightness; PATCH_COUNT patches
// of the floor of two cells each; and the responses of sensors, a cell for each point.

// A sensor's first cell.
struct SensorCell {
    // where it looks, and is on the body unless it has a bearing, in turns, counter-clockwise from straight ahead
    heading: f32,
    // mm from the body's centre
    offset: f32,
    // mm; of a light sensor its law
    range: f32,
    // the inverse of the range; of a bumper half its width in turns
    share: f32,
}

// The laws of light sensors; any other is 1 / (1 + d^2).
const LAW_LINEAR: f32 = 0.0f;
const LAW_EXPONENTIAL: f32 = 1.0f;

fn sensor_of(world: u32, cell: u32) -> SensorCell {
    let numbers = numbers(world, cell);
    return SensorCell(numbers.x, numbers.y, numbers.z, numbers.w);
}

// A bumper's reading of one object, whose nearest point lies at this squared distance and bearing: 1 if that is within the
// bumper's width, and nearer to the body than its range.
fn bumper_at(shape: u32, squared: f32, bearing: f32, sensor: SensorCell, looks: f32) -> f32 {
    let reach = shapes[shape].contact + sensor.range;
    let turned = bearing - looks;
    let off = abs(turned - floor(turned + 0.5f));
    // Within an object every side is pressed.
    let faces = (off <= sensor.share) | (squared == 0.0f);
    return select(0.0f, 1.0f, (squared < reach * reach) & faces);
}

// How far one object leaves a sensor's ray free, mm from the sensor and its offset besides. The sensor is elsewhere on the body,
// in the direction `outward` from the centre, than it looks, `ahead`. What lies between the centre and its place leaves nothing.
fn free_from_place(shape: u32, at: vec2<f32>, outward: vec2<f32>, ahead: vec2<f32>, sensor: SensorCell) -> f32 {
    if (ray_to_shape(shape, at, outward, sensor.offset) < sensor.offset) {
        return 0.0f;
    }
    return sensor.offset + ray_to_shape(shape, at + sensor.offset * outward, ahead, sensor.range);
}

// The reading of a ray that leaves `free` mm free, the sensor's offset included: a fraction of the range, 0 to 1. A ray begins at
// the body's centre, or goes from there to the sensor's place first, so a sensor within an object or behind it reads 0.
fn range_share(sensor: SensorCell, free: f32) -> f32 {
    let share = clamp((free - sensor.offset) * sensor.share, 0.0f, 1.0f);
    return select(flushed(share), 1.0f, free >= sensor.offset + sensor.range);
}

// The brightness of all lights that no object hides, at most 1.
fn light_reading(world: u32, place: vec2<f32>, sensor: SensorCell, looks: f32) -> f32 {
    var sum = 0.0f;
    for (var index = 0u; index < LIGHT_COUNT; index++) {
        let light = numbers(world, FLOOR_CELL + 1u + index);
        let to = vec2<f32>(light.x - place.x, light.y - place.y);
        let distance = root(max(squared_length(to), 0x1p-10f));
        let toward_light = direction(to);
        let turned = toward_light - looks;
        // From a quarter turn off on it reads nothing.
        let facing = 1.0f - 4.0f * abs(turned - floor(turned + 0.5f));
        if (facing > 0.0f) {
            // A light may stand at a wall.
            if (ray_in_world(world, place, toward_light, distance) >= distance - 1.0f) {
                sum += light.z * facing * brightness_share(sensor, distance);
            }
        }
    }
    return min(flushed(sum), 1.0f);
}

// The fraction of its brightness that a light has at a distance.
fn brightness_share(sensor: SensorCell, distance: f32) -> f32 {
    let d = distance * sensor.share;
    if (sensor.range == LAW_LINEAR) {
        return max(1.0f - d, 0.0f);
    }
    if (sensor.range == LAW_EXPONENTIAL) {
        // e^-43 is 2e-19.
        return exponential(max(-d, -43.0f));
    }
    return reciprocal(1.0f + d * d);
}

// The grey of the floor below the sensor.
fn ground_reading(world: u32, place: vec2<f32>) -> f32 {
    return patches_grey(world, place, numbers(world, FLOOR_CELL).x);
}

// The grey of the last patch at a place; `beyond` where there is none.
fn patches_grey(world: u32, place: vec2<f32>, beyond: f32) -> f32 {
    var grey = beyond;
    for (var index = 0u; index < PATCH_COUNT; index++) {
        let patch_grey = numbers(world, FLOOR_CELL + LIGHT_COUNT + 2u * index + 2u).w;
        grey = select(grey, patch_grey, is_on_patch(world, index, place));
    }
    return grey;
}

// Whether a point is on a patch of the floor.
fn is_on_patch(world: u32, index: u32, place: vec2<f32>) -> bool {
    let first = FLOOR_CELL + 1u + LIGHT_COUNT + 2u * index;
    let centre = numbers(world, first);
    let size = numbers(world, first + 1u);
    let from_centre = vec2<f32>(place.x - centre.x, place.y - centre.y);
    let along = abs(from_centre.x * centre.z + from_centre.y * centre.w);
    let across = abs(from_centre.y * centre.z - from_centre.x * centre.w);
    let is_round = squared_length(from_centre) < size.z;
    let is_within = (along <= size.x) & (across <= size.y) & (size.z == 0.0f);
    return is_round | is_within;
}

// The reading of a ray that leaves `free` mm free, the sensor's offset included. The response curve has `points` points, in
// cells from `first` on, joined by straight lines. 0 if nothing is in range.
fn response_reading(world: u32, sensor: SensorCell, free: f32, first: u32, points: u32) -> f32 {
    let distance = max(free - sensor.offset, 0.0f);
    var reading = numbers(world, first).y;
    for (var index = 0u; index < points; index++) {
        // its distance and reading, and what the reading changes by for each mm beyond
        let point = numbers(world, first + index);
        reading = select(reading, point.y + (distance - point.x) * point.z, distance >= point.x);
    }
    return select(flushed(clamp(reading, 0.0f, 1.0f)), 0.0f, free >= sensor.offset + sensor.range);
}

// The charge of a battery that was full some cycles ago: from 1 for full to 0 for empty.
fn battery_reading(world: u32, used: u32) -> f32 {
    let drive = drive_of(world);
    let charge = 1.0f - f32(used) * drive.cycle;
    return select(flushed(charge), 0.0f, f32(used) >= drive.cycles);
}
