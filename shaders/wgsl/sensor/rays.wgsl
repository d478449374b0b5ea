// Eight infra-red sensors of an individual robot, by rays. A sensor sends eight rays; each returns from the
// nearest surface with the cosine of its incidence, the surface's reflectivity and the inverse square of the
// distance. What returns in all is turned into the distance of a wall that would return as much head-on, and
// that by the sensor's own curve into its reading: a logistic that is clipped where the sensor saturates.
//
// All that the samples of single objects don't contain is here, each with a strength that may be 0: true corners
// and occlusion, reflectivity, illumination, noise of reading, and that readings are old.

// The rays' angles from the sensor's axis, both ways, in degrees, and their cosines and sines.
const RAY_DEGREES: vec4<f32> = vec4<f32>(7.5f, 22.5f, 37.5f, 52.5f);
const RAY_COSINES: vec4<f32> = vec4<f32>(0.9914449f, 0.9238795f, 0.7933533f, 0.6087614f);
const RAY_SINES: vec4<f32> = vec4<f32>(0.1305262f, 0.3826834f, 0.6087614f, 0.7933533f);

// No surface is nearer to a sensor than this, mm.
const NEAREST: f32 = 0.1f;
// A reading is an integer up to this.
const GREATEST_READING: f32 = 1023.0f;
const READING: f32 = 0.0009775171f; // 1 / 1023

// Four rays of one sensor from one point: their directions.
struct Rays {
    x: vec4<f32>,
    y: vec4<f32>,
}

// What four rays have met: the inverse of the distance, and the light that comes back from there.
struct Met {
    nearness: vec4<f32>,
    light: vec4<f32>,
}

fn nothing_met() -> Met {
    return Met(vec4<f32>(0.0f), vec4<f32>(0.0f));
}

// A sensor's rays lie on both sides of its axis, four on each.
const SIDES: u32 = 2u;

// The rays on one side of an axis: 0 is the left, 1 the right.
fn rays_of(axis: vec2<f32>, number: u32) -> Rays {
    let side = select(1.0f, -1.0f, number == 1u);
    return Rays(
        axis.x * RAY_COSINES - (side * axis.y) * RAY_SINES,
        axis.y * RAY_COSINES + (side * axis.x) * RAY_SINES,
    );
}

// Keeps the nearer of what was met and what is met now, where it is met at all.
fn nearer(met: Met, hit: vec4<bool>, nearness: vec4<f32>, light: vec4<f32>) -> Met {
    let kept = hit & (nearness > met.nearness);
    return Met(select(met.nearness, nearness, kept), select(met.light, light, kept));
}

// Rays against a plane that lies at a distance (mm, from where they start) in the direction `normal`.
fn meet_plane(met: Met, rays: Rays, normal: vec2<f32>, distance: f32, reflectivity: f32) -> Met {
    let incidence = rays.x * normal.x + rays.y * normal.y;
    let nearness = incidence * reciprocal(max(distance, NEAREST));
    return nearer(met, incidence > vec4<f32>(0.0f), nearness, incidence * reflectivity);
}

// Rays against a wall, from the point `at`. A ray at distance 1 / nearness meets the wall between its ends.
fn meet_wall(met: Met, rays: Rays, at: vec2<f32>, shape: u32) -> Met {
    let from_x = at.x - shapes[shape].x;
    let from_y = at.y - shapes[shape].y;
    let across = shapes[shape].unit_x * from_y - shapes[shape].unit_y * from_x;
    // The normal that looks from the point to the wall.
    let normal_x = select(-shapes[shape].unit_y, shapes[shape].unit_y, across > 0.0f);
    let normal_y = select(shapes[shape].unit_x, -shapes[shape].unit_x, across > 0.0f);
    let distance = max(abs(across), NEAREST);
    let incidence = rays.x * normal_x + rays.y * normal_y;
    // Where along the wall, as a share of its length, times the incidence.
    let start = from_x * shapes[shape].scaled_x + from_y * shapes[shape].scaled_y;
    let along = start * incidence + distance * (rays.x * shapes[shape].scaled_x + rays.y * shapes[shape].scaled_y);
    let hit = (incidence > vec4<f32>(0.0f)) & (along >= vec4<f32>(0.0f)) & (along <= incidence);
    return nearer(met, hit, incidence * reciprocal(distance), incidence * shapes[shape].reflectivity);
}

// Rays against a cylinder whose centre lies at `to` from where they start.
fn meet_cylinder(met: Met, rays: Rays, to: vec2<f32>, radius: f32, reflectivity: f32) -> Met {
    // The product of the distances to both surfaces, the near and the far one.
    let product = max(squared_length(to) - radius * radius, NEAREST * NEAREST);
    let middle = rays.x * to.x + rays.y * to.y;
    let square = middle * middle - product;
    let half = vec4<f32>(
        root(max(square.x, 0.0f)), root(max(square.y, 0.0f)), root(max(square.z, 0.0f)), root(max(square.w, 0.0f)),
    );
    let incidence = min(half * reciprocal(max(radius, NEAREST)), vec4<f32>(1.0f));
    let hit = (middle > vec4<f32>(0.0f)) & (square >= vec4<f32>(0.0f));
    return nearer(met, hit, (middle + half) * reciprocal(product), incidence * reflectivity);
}

// Rays against a block's two faces that look to where they start. The block has that point as `own`, its length
// lies along `unit`, and its sides are twice `half`.
fn meet_block(met: Met, rays: Rays, own: vec2<f32>, unit: vec2<f32>, half: vec2<f32>, reflectivity: f32) -> Met {
    let along = rays.x * unit.x + rays.y * unit.y;
    let across = rays.y * unit.x - rays.x * unit.y;
    var all = met;
    for (var face = 0u; face < 2u; face++) {
        let side = face == 1u;
        all = meet_face(
            all, select(along, across, side), select(across, along, side),
            select(own, own.yx, side), select(half, half.yx, side), reflectivity,
        );
    }
    return all;
}

// Rays against the face of a block that closes its first axis on the side of `own`; rays have the parts `first` along
// that axis and `second` along the other. One at the distance 1 / nearness meets the face between its ends.
fn meet_face(
    met: Met, first: vec4<f32>, second: vec4<f32>, own: vec2<f32>, half: vec2<f32>, reflectivity: f32,
) -> Met {
    let side = select(1.0f, -1.0f, own.x > 0.0f);
    let incidence = side * first;
    let distance = max(abs(own.x) - half.x, NEAREST);
    let place = own.y * incidence + distance * second;
    let ends = half.y * incidence;
    let faces = abs(own.x) > half.x;
    let hit = vec4<bool>(faces) & (incidence > vec4<f32>(0.0f)) & (place >= -ends) & (place <= ends);
    return nearer(met, hit, incidence * reciprocal(distance), incidence * reflectivity);
}

// A sensor's reading, as an integer, of what its rays on both sides bring back, in so much more light.
fn reading_of(world: u32, sensor: u32, light_of_pairs: vec4<f32>, gain: f32) -> u32 {
    let weights = numbers(world, sensor * SENSOR_CELLS + RAY_WEIGHTS);
    let curve = curve_of(world, sensor);
    let returned = weights * light_of_pairs;
    let light = gain * ((returned.x + returned.y) + (returned.z + returned.w));
    let distance = reciprocal_root(max(light, 0x1p-40f));
    let x = clamp((distance - curve.half) * curve.steepness, -30.0f, 30.0f);
    return whole(1.5f * reciprocal(1.0f + 2.0f * exponential_within(x)));
}

// An activation, clipped to [0, 1], as the integer that the robot reads.
fn whole(activation: f32) -> u32 {
    return u32(clamp(activation, 0.0f, 1.0f) * GREATEST_READING + 0.5f);
}

// Eight integers with `value` added to that of one sensor.
struct Sums {
    first: vec4<u32>,
    last: vec4<u32>,
}

fn added(sums: Sums, sensor: u32, value: u32) -> Sums {
    let one = vec4<u32>(sensor & 3u) == vec4<u32>(0u, 1u, 2u, 3u);
    let term = select(vec4<u32>(0u), vec4<u32>(value), one);
    if (sensor < 4u) {
        return Sums(sums.first + term, sums.last);
    }
    return Sums(sums.first, sums.last + term);
}

// The objects in reach of a robot that stands there, a bit each: the first 32 of its world, and the others.
fn in_reach(world: u32, at: vec2<f32>) -> vec2<u32> {
    let first = worlds[world].first_shape;
    let count = shape_count(world);
    var near = vec2<u32>(0u);
    for (var index = 0u; index < count; index++) {
        let shape = first + index;
        let bit = select(0u, 1u << (index & 31u), squared_length(toward(shape, at)) < shapes[shape].reach_squared);
        if (index < 32u) {
            near.x |= bit;
        } else {
            near.y |= bit;
        }
    }
    return near;
}

// Whether an object is among them, by its index in the world.
fn is_near(near: vec2<u32>, index: u32) -> bool {
    let bits = select(near.y, near.x, index < 32u);
    return ((bits >> (index & 31u)) & 1u) != 0u;
}

// What the sensors read at a pose when all rays meet all that is there.
fn traced_readings(world: u32, pose: vec3<f32>, gain: f32) -> Sums {
    let ahead = cosine_sine(pose.z);
    let first = worlds[world].first_shape;
    let count = shape_count(world);
    let near = in_reach(world, vec2<f32>(pose.x, pose.y));
    var sums = Sums(vec4<u32>(0u), vec4<u32>(0u));
    for (var sensor = 0u; sensor < 8u; sensor++) {
        let place = place_of(world, sensor);
        let at = vec2<f32>(
            pose.x + place.x * ahead.x - place.y * ahead.y,
            pose.y + place.x * ahead.y + place.y * ahead.x,
        );
        let axis = vec2<f32>(place.axis_x * ahead.x - place.axis_y * ahead.y, place.axis_x * ahead.y + place.axis_y * ahead.x);
        var light = vec4<f32>(0.0f);
        for (var side = 0u; side < SIDES; side++) {
            let rays = rays_of(axis, side);
            var met = nothing_met();
            for (var index = 0u; index < count; index++) {
                if (is_near(near, index)) {
                    let shape = first + index;
                    let reflectivity = shapes[shape].reflectivity;
                    if (shapes[shape].kind == ROUND) {
                        let to = vec2<f32>(shapes[shape].x - at.x, shapes[shape].y - at.y);
                        met = meet_cylinder(met, rays, to, shapes[shape].radius, reflectivity);
                    } else if (shapes[shape].kind == BLOCK) {
                        let unit = vec2<f32>(shapes[shape].unit_x, shapes[shape].unit_y);
                        let half = vec2<f32>(shapes[shape].half_length, shapes[shape].half_width);
                        met = meet_block(met, rays, within(shape, at), unit, half, reflectivity);
                    } else {
                        met = meet_wall(met, rays, at, shape);
                    }
                }
            }
            light += met.light * met.nearness * met.nearness;
        }
        sums = added(sums, sensor, reading_of(world, sensor, light, gain));
    }
    return sums;
}

// An object as it is seen alone in the open: its bearing's direction and its distance from the robot's centre, both
// as the samples' grid has them. A block has half its sides, how many views it was sampled from, and first the robot's
// centre as it has it; then, in the robot's frame, its own centre and the direction of its length.
struct Lone {
    normal: vec2<f32>,
    distance: f32,
    kind: u32,
    radius: f32,
    reflectivity: f32,
    half: vec2<f32>,
    views: u32,
    own: vec2<f32>,
    centre: vec2<f32>,
    unit: vec2<f32>,
}

fn nothing_alone() -> Lone {
    let none = vec2<f32>(0.0f, 0.0f);
    return Lone(none, 0.0f, 0u, 0.0f, 0.0f, none, 1u, none, none, none);
}

// A block as it is seen alone from the middle of a point of view, at its distance and bearing.
fn viewed(block: Lone) -> Lone {
    let view = view_from(block.own, block.views);
    let ray = cosine_sine((f32(view) + 0.5f) * reciprocal(2.0f * f32(block.views)));
    let along = abs(ray.x);
    let across = abs(ray.y);
    // From the centre to where the distance is as wanted: before the end, before the long side, or beside a corner.
    let before_end = (block.half.x + block.distance) * reciprocal(max(along, 0x1p-10f));
    let before_side = (block.half.y + block.distance) * reciprocal(max(across, 0x1p-10f));
    let corner = block.half.x * along + block.half.y * across;
    let past = squared_length(block.half) - corner * corner;
    let beside = corner + root(max(block.distance * block.distance - past, 0.0f));
    let sideways = select(beside, before_side, before_side * along <= block.half.x);
    let far = select(sideways, before_end, before_end * across <= block.half.y);
    // There, and from there to the nearest point.
    let x = select(far * along, -(far * along), ray.x < 0.0f);
    let y = far * across;
    let to_x = (clamp(x, -block.half.x, block.half.x) - x) * reciprocal(block.distance);
    let to_y = (min(y, block.half.y) - y) * reciprocal(block.distance);
    // The turn that takes it to the bearing.
    var seen = block;
    seen.unit = vec2<f32>(
        block.normal.x * to_x + block.normal.y * to_y,
        block.normal.y * to_x - block.normal.x * to_y,
    );
    seen.centre = vec2<f32>(seen.unit.y * y - seen.unit.x * x, -(seen.unit.y * x) - seen.unit.x * y);
    return seen;
}

// What one object alone adds to the sensors' readings.
fn lone_reading(world: u32, object: Lone, gain: f32) -> Sums {
    var sums = Sums(vec4<u32>(0u), vec4<u32>(0u));
    for (var sensor = 0u; sensor < 8u; sensor++) {
        let place = place_of(world, sensor);
        var light = vec4<f32>(0.0f);
        for (var side = 0u; side < SIDES; side++) {
            let rays = rays_of(vec2<f32>(place.axis_x, place.axis_y), side);
            var met = nothing_met();
            if (object.kind == ROUND) {
                let centre = vec2<f32>(
                    object.distance * object.normal.x - place.x, object.distance * object.normal.y - place.y,
                );
                met = meet_cylinder(met, rays, centre, object.radius, object.reflectivity);
            } else if (object.kind == BLOCK) {
                let from_x = place.x - object.centre.x;
                let from_y = place.y - object.centre.y;
                let own = vec2<f32>(
                    from_x * object.unit.x + from_y * object.unit.y, from_y * object.unit.x - from_x * object.unit.y,
                );
                met = meet_block(met, rays, own, object.unit, object.half, object.reflectivity);
            } else {
                let beyond = object.distance - (place.x * object.normal.x + place.y * object.normal.y);
                met = meet_plane(met, rays, object.normal, beyond, object.reflectivity);
            }
            light += met.light * met.nearness * met.nearness;
        }
        sums = added(sums, sensor, reading_of(world, sensor, light, gain));
    }
    return sums;
}

// What the sensors would read if every object stood alone in the open, at the distance and bearing of the
// samples' grid that is below its own, and readings of several objects were added: the simulator's picture.
//
// Few objects are in reach at once, though other lanes have others: so each turn takes every lane's next one.
fn lone_readings(world: u32, pose: vec3<f32>, gain: f32) -> Sums {
    let first = worlds[world].first_shape;
    let count = shape_count(world);
    let end = first + count;
    let spacing = reciprocal(worlds[world].rows_per_mm);
    var sums = Sums(vec4<u32>(0u), vec4<u32>(0u));
    var in_reach = 1u;
    for (var turn = 0u; turn < min(in_reach, count); turn++) {
        var to = vec2<f32>(0.0f, 0.0f);
        var inverse = 0.0f;
        var row = 0u;
        var contact = 0.0f;
        var object = nothing_alone();
        in_reach = 0u;
        for (var shape = first; shape < end; shape++) {
            let candidate = toward(shape, vec2<f32>(pose.x, pose.y));
            let squared = squared_length(candidate);
            let over = reciprocal_root(max(squared, 0x1p-60f));
            let gap = squared * over - shapes[shape].contact;
            let at = row_of(world, gap);
            if (at < worlds[world].rows) {
                if (in_reach == turn) {
                    to = candidate;
                    inverse = over;
                    row = at;
                    contact = shapes[shape].contact;
                    object.kind = shapes[shape].kind;
                    object.radius = shapes[shape].radius;
                    object.reflectivity = shapes[shape].reflectivity;
                    if (shapes[shape].kind == BLOCK) {
                        object.half = vec2<f32>(shapes[shape].half_length, shapes[shape].half_width);
                        object.views = shapes[shape].views;
                        object.own = within(shape, vec2<f32>(pose.x, pose.y));
                    }
                }
                in_reach++;
            }
        }
        if (turn < in_reach) {
            let bearing = bearing_of(world, pose.z, to, inverse);
            object.normal = cosine_sine(-f32(bearing) * reciprocal(worlds[world].bearings_per_turn));
            object.distance = contact + (worlds[world].nearest + f32(row) * spacing);
            if (object.kind == BLOCK) {
                object = viewed(object);
            }
            let reading = lone_reading(world, object, gain);
            sums = Sums(sums.first + reading.first, sums.last + reading.last);
        }
    }
    return sums;
}

// How much more light returns at a place than elsewhere: 1 and the sum of the field's waves.
fn illumination(world: u32, at: vec2<f32>) -> f32 {
    var gain = 1.0f;
    for (var wave = 0u; wave < WAVE_COUNT; wave++) {
        let own = wave_of(world, wave);
        gain += own.amplitude * cosine_sine(own.turns_x * at.x + own.turns_y * at.y + own.phase).x;
    }
    return max(gain, 0.0f);
}

// The integer that the robot gets: the simulator's picture, and of what the true one differs from it the share
// `geometry`, with the noise of reading, over the surroundings' own light.
fn read_out(lone: u32, traced: u32, strength: SensingCell, word: u32) -> u32 {
    let summed = min(f32(lone) * READING, 1.0f);
    let seen = clamp(summed + strength.geometry * (f32(traced) * READING - summed), 0.0f, 1.0f);
    return whole(seen + strength.ambient + nearly_normal(word) * (strength.noise + strength.noise_share * seen));
}

// The robot's readings at the pose where it was when they were taken.
fn sense_by_rays(life: Life, step: u32, pose: vec3<f32>) -> Readings {
    let world = life.world;
    let strength = sensing_of(world);
    let gain = illumination(world, vec2<f32>(pose.x, pose.y));
    var lone = Sums(vec4<u32>(0u), vec4<u32>(0u));
    var traced = lone;
    if (strength.geometry != 1.0f) {
        lone = lone_readings(world, pose, gain);
    }
    if (strength.geometry != 0.0f) {
        traced = traced_readings(world, pose, gain);
    }
    let a = random_words(life.key, STREAM_SENSOR, step, 0u);
    let b = random_words(life.key, STREAM_SENSOR, step, 1u);
    let scale = worlds[world].reading_scale;
    return Readings(
        four_read_out(lone.first, traced.first, strength, a, scale),
        four_read_out(lone.last, traced.last, strength, b, scale),
        SensorReadings(),
    );
}

// Four of them, as activations.
fn four_read_out(lone: vec4<u32>, traced: vec4<u32>, strength: SensingCell, words: vec4<u32>, scale: f32) -> vec4<f32> {
    return vec4<f32>(
        activation(read_out(lone.x, traced.x, strength, words.x), scale),
        activation(read_out(lone.y, traced.y, strength, words.y), scale),
        activation(read_out(lone.z, traced.z, strength, words.z), scale),
        activation(read_out(lone.w, traced.w, strength, words.w), scale),
    );
}
