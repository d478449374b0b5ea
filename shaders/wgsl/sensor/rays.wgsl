// Eight infra-red sensors of an individual robot, by rays. A sensor sends eight rays; each returns from the
// nearest surface with the cosine of its incidence, the surface's reflectivity and the inverse square of the
// distance. The returned light is turned into the distance of a wall that would return as much head-on, and
// that by the sensor's curve into its reading: a logistic that is clipped where the sensor saturates.
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

// What four rays meet: the inverse of the distance, 0 or less where they meet nothing, and the light that comes back.
struct Met {
    nearness: vec4<f32>,
    light: vec4<f32>,
}

fn nothing_met() -> Met {
    return Met(vec4<f32>(0.0f), vec4<f32>(0.0f));
}

// A sensor's rays lie on both sides of its axis, four on each.
struct Fan {
    left: Rays,
    right: Rays,
}

fn fan_of(axis: vec2<f32>) -> Fan {
    let along_x = axis.x * RAY_COSINES;
    let along_y = axis.y * RAY_COSINES;
    let aside_x = axis.x * RAY_SINES;
    let aside_y = axis.y * RAY_SINES;
    return Fan(Rays(along_x - aside_y, along_y + aside_x), Rays(along_x + aside_y, along_y - aside_x));
}

// What a fan meets.
struct Seen {
    left: Met,
    right: Met,
}

fn nothing_seen() -> Seen {
    return Seen(nothing_met(), nothing_met());
}

// Keeps the nearer of two, of equally near ones the first.
fn nearer(met: Met, other: Met) -> Met {
    let light = select(met.light, other.light, other.nearness > met.nearness);
    return Met(max(met.nearness, other.nearness), light);
}

fn nearer_seen(seen: Seen, other: Seen) -> Seen {
    return Seen(nearer(seen.left, other.left), nearer(seen.right, other.right));
}

// The light that comes back to the sensor, of pairs of rays.
fn returned(seen: Seen) -> vec4<f32> {
    let left = max(seen.left.nearness, vec4<f32>(0.0f));
    let right = max(seen.right.nearness, vec4<f32>(0.0f));
    return seen.left.light * left * left + seen.right.light * right * right;
}

// Rays against a plane that lies in the direction `normal`, at the inverse of a distance. Those that look away are at less
// than 0.
fn meet_plane(rays: Rays, normal: vec2<f32>, inverse: f32, reflectivity: f32) -> Met {
    let incidence = rays.x * normal.x + rays.y * normal.y;
    return Met(incidence * inverse, incidence * reflectivity);
}

// A wall from a point: the normal that looks from the point to the wall, the distance and its inverse, where the wall
// begins, as a fraction of its length, and its direction over its length.
struct WallSeen {
    normal: vec2<f32>,
    distance: f32,
    inverse: f32,
    start: f32,
    scaled: vec2<f32>,
    reflectivity: f32,
}

fn wall_from(at: vec2<f32>, wall: Thing) -> WallSeen {
    let from_x = at.x - wall.x;
    let from_y = at.y - wall.y;
    let across = wall.unit_x * from_y - wall.unit_y * from_x;
    let normal_x = select(-wall.unit_y, wall.unit_y, across > 0.0f);
    let normal_y = select(wall.unit_x, -wall.unit_x, across > 0.0f);
    let distance = max(abs(across), NEAREST);
    let start = from_x * wall.extent_x + from_y * wall.extent_y;
    return WallSeen(
        vec2<f32>(normal_x, normal_y), distance, reciprocal(distance), start,
        vec2<f32>(wall.extent_x, wall.extent_y), wall.reflectivity,
    );
}

// Rays against a wall. One at distance 1 / nearness meets it between its ends.
fn meet_wall(rays: Rays, wall: WallSeen) -> Met {
    let plane = meet_plane(rays, wall.normal, wall.inverse, wall.reflectivity);
    let incidence = rays.x * wall.normal.x + rays.y * wall.normal.y;
    // Where along the wall, as a fraction of its length, times the incidence.
    let along = wall.start * incidence + wall.distance * (rays.x * wall.scaled.x + rays.y * wall.scaled.y);
    let hit = (along >= vec4<f32>(0.0f)) & (along <= incidence);
    return Met(select(vec4<f32>(0.0f), plane.nearness, hit), plane.light);
}

// A cylinder from a point: where its centre lies, the product of the distances to both surfaces, the near and the far
// one, its inverse, and that of the radius.
struct CylinderSeen {
    to: vec2<f32>,
    product: f32,
    inverse: f32,
    inverse_radius: f32,
    reflectivity: f32,
}

fn cylinder_from(to: vec2<f32>, radius: f32, reflectivity: f32) -> CylinderSeen {
    let product = max(squared_length(to) - radius * radius, NEAREST * NEAREST);
    return CylinderSeen(to, product, reciprocal(product), reciprocal(max(radius, NEAREST)), reflectivity);
}

// Rays against a cylinder. Of one that passes by, half of the way through it is the root of a negative number, which is
// far below 0, and so is the nearness. A ray that points away misses.
fn meet_cylinder(rays: Rays, cylinder: CylinderSeen) -> Met {
    let middle = max(rays.x * cylinder.to.x + rays.y * cylinder.to.y, vec4<f32>(0.0f));
    let square = middle * middle - cylinder.product;
    let half = vec4<f32>(root(square.x), root(square.y), root(square.z), root(square.w));
    let incidence = min(half * cylinder.inverse_radius, vec4<f32>(1.0f));
    return Met((middle + half) * cylinder.inverse, incidence * cylinder.reflectivity);
}

// Rays against a block's two faces that look to where they start. The block has that point as `origin`, its length
// lies along `unit`, and its sides are twice `half`.
fn meet_block(rays: Rays, origin: vec2<f32>, unit: vec2<f32>, half: vec2<f32>, reflectivity: f32) -> Met {
    let along = rays.x * unit.x + rays.y * unit.y;
    let across = rays.y * unit.x - rays.x * unit.y;
    var all = nothing_met();
    for (var face = 0u; face < 2u; face++) {
        let side = face == 1u;
        let met = meet_face(
            select(along, across, side), select(across, along, side),
            select(origin, origin.yx, side), select(half, half.yx, side), reflectivity,
        );
        all = nearer(all, met);
    }
    return all;
}

// Rays against the face of a block that closes its first axis on the side of `origin`; rays have the parts `first` along
// that axis and `second` along the other. One at the distance 1 / nearness meets the face between its ends.
fn meet_face(first: vec4<f32>, second: vec4<f32>, origin: vec2<f32>, half: vec2<f32>, reflectivity: f32) -> Met {
    let side = select(1.0f, -1.0f, origin.x > 0.0f);
    let incidence = side * first;
    let distance = max(abs(origin.x) - half.x, NEAREST);
    let place = origin.y * incidence + distance * second;
    let ends = half.y * incidence;
    let faces = abs(origin.x) > half.x;
    let hit = vec4<bool>(faces) & (place >= -ends) & (place <= ends);
    return Met(select(vec4<f32>(0.0f), incidence * reciprocal(distance), hit), incidence * reflectivity);
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

// Eight integers of 16 bits, the even sensors' in the low halves, with that of one sensor, which was 0.
fn with_reading(readings: vec4<u32>, sensor: u32, reading: u32) -> vec4<u32> {
    let mask = select(vec4<u32>(0u), vec4<u32>(0xffffffffu), vec4<u32>(sensor >> 1u) == vec4<u32>(0u, 1u, 2u, 3u));
    return readings | (vec4<u32>(reading << ((16u * sensor) & 31u)) & mask);
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

// What is needed of an object's numbers. Its extent is its radius if it is round, half its length and width if it is a
// block, and a wall's direction over its length.
struct Thing {
    kind: u32,
    x: f32,
    y: f32,
    unit_x: f32,
    unit_y: f32,
    length_x: f32,
    length_y: f32,
    extent_x: f32,
    extent_y: f32,
    contact: f32,
    views: u32,
    reflectivity: f32,
}

fn thing(shape: u32) -> Thing {
    let kind = shapes[shape].kind;
    let flat_x = select(shapes[shape].scaled_x, shapes[shape].half_length, kind == BLOCK);
    let flat_y = select(shapes[shape].scaled_y, shapes[shape].half_width, kind == BLOCK);
    return Thing(
        kind, shapes[shape].x, shapes[shape].y, shapes[shape].unit_x, shapes[shape].unit_y, shapes[shape].length_x,
        shapes[shape].length_y, select(flat_x, shapes[shape].radius, kind == ROUND), flat_y, shapes[shape].contact,
        shapes[shape].views, shapes[shape].reflectivity,
    );
}

// What a fan of rays from a point meets of an object of a kind.
fn meet(fan: Fan, at: vec2<f32>, kind: u32, object: Thing) -> Seen {
    if (kind == ROUND) {
        let to = vec2<f32>(object.x - at.x, object.y - at.y);
        let cylinder = cylinder_from(to, object.extent_x, object.reflectivity);
        return Seen(meet_cylinder(fan.left, cylinder), meet_cylinder(fan.right, cylinder));
    }
    if (kind == BLOCK) {
        let from_x = at.x - object.x;
        let from_y = at.y - object.y;
        let unit = vec2<f32>(object.unit_x, object.unit_y);
        let origin = vec2<f32>(from_x * unit.x + from_y * unit.y, from_y * unit.x - from_x * unit.y);
        let half = vec2<f32>(object.extent_x, object.extent_y);
        return Seen(
            meet_block(fan.left, origin, unit, half, object.reflectivity),
            meet_block(fan.right, origin, unit, half, object.reflectivity),
        );
    }
    let wall = wall_from(at, object);
    return Seen(meet_wall(fan.left, wall), meet_wall(fan.right, wall));
}

// The readings at a pose when all rays meet all objects.
//
// From nowhere are two objects of one layer in reach, and all of a layer are of one kind. So rays meet one object a layer,
// which lanes that stand near different objects then do together.
fn traced_readings(world: u32, pose: vec3<f32>, gain: f32) -> vec4<u32> {
    let ahead = cosine_sine(pose.z);
    let first = worlds[world].first_shape;
    let count = shape_count(world);
    let near = in_reach(world, vec2<f32>(pose.x, pose.y));
    var sums = vec4<u32>(0u);
    for (var sensor = 0u; sensor < 8u; sensor++) {
        let place = place_of(world, sensor);
        let at = vec2<f32>(
            pose.x + place.x * ahead.x - place.y * ahead.y,
            pose.y + place.x * ahead.y + place.y * ahead.x,
        );
        let axis = vec2<f32>(place.axis_x * ahead.x - place.axis_y * ahead.y, place.axis_x * ahead.y + place.axis_y * ahead.x);
        let fan = fan_of(axis);
        var seen = nothing_seen();
        var object = thing(first);
        var begins = true;
        var found = false;
        for (var index = 0u; index < count; index++) {
            let shape = first + index;
            let is_in_reach = is_near(near, index);
            if (is_in_reach | begins) {
                object = thing(shape);
            }
            found = is_in_reach | (found & !begins);
            begins = shapes[shape].ends_layer != 0u;
            if (begins & found) {
                seen = nearer_seen(seen, meet(fan, at, shapes[shape].kind, object));
            }
        }
        sums = with_reading(sums, sensor, reading_of(world, sensor, returned(seen), gain));
    }
    return sums;
}

// An object alone in the open: its bearing's direction and its distance from the robot's centre, both
// as the samples' grid has them. A block has half its sides, how many views it was sampled from, and first the robot's
// centre as it has it; then, in the robot's frame, the block's centre and the direction of its length.
struct Lone {
    normal: vec2<f32>,
    distance: f32,
    kind: u32,
    radius: f32,
    reflectivity: f32,
    half: vec2<f32>,
    views: u32,
    robot: vec2<f32>,
    centre: vec2<f32>,
    unit: vec2<f32>,
}

fn nothing_alone() -> Lone {
    let none = vec2<f32>(0.0f, 0.0f);
    return Lone(none, 0.0f, 0u, 0.0f, 0.0f, none, 1u, none, none, none);
}

// A block alone, from the middle of a point of view, at its distance and bearing.
fn viewed(block: Lone) -> Lone {
    let view = view_from(block.robot, block.views);
    let ray = cosine_sine((f32(view) + 0.5f) * reciprocal(2.0f * f32(block.views)));
    let along = abs(ray.x);
    let across = abs(ray.y);
    // From the centre to where the distance is as wanted: before the end, before the long side, or next to a corner.
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

// What objects alone in the open add to the sensors' readings: a wall or a block, and something round, where they are.
fn lone_reading(world: u32, flat: Lone, is_flat: bool, round: Lone, is_round: bool, gain: f32) -> vec4<u32> {
    var sums = vec4<u32>(0u);
    for (var sensor = 0u; sensor < 8u; sensor++) {
        let place = place_of(world, sensor);
        let fan = fan_of(vec2<f32>(place.axis_x, place.axis_y));
        var reading = 0u;
        if (is_flat) {
            var seen = nothing_seen();
            if (flat.kind == BLOCK) {
                let from_x = place.x - flat.centre.x;
                let from_y = place.y - flat.centre.y;
                let origin = vec2<f32>(
                    from_x * flat.unit.x + from_y * flat.unit.y, from_y * flat.unit.x - from_x * flat.unit.y,
                );
                seen = Seen(
                    meet_block(fan.left, origin, flat.unit, flat.half, flat.reflectivity),
                    meet_block(fan.right, origin, flat.unit, flat.half, flat.reflectivity),
                );
            } else {
                let beyond = flat.distance - (place.x * flat.normal.x + place.y * flat.normal.y);
                let inverse = reciprocal(max(beyond, NEAREST));
                seen = Seen(
                    meet_plane(fan.left, flat.normal, inverse, flat.reflectivity),
                    meet_plane(fan.right, flat.normal, inverse, flat.reflectivity),
                );
            }
            reading = reading_of(world, sensor, returned(seen), gain);
        }
        if (is_round) {
            let centre = vec2<f32>(
                round.distance * round.normal.x - place.x, round.distance * round.normal.y - place.y,
            );
            let cylinder = cylinder_from(centre, round.radius, round.reflectivity);
            let seen = Seen(meet_cylinder(fan.left, cylinder), meet_cylinder(fan.right, cylinder));
            reading += reading_of(world, sensor, returned(seen), gain);
        }
        sums = with_reading(sums, sensor, reading);
    }
    return sums;
}

// From a point to the nearest point of an object, or to a round one's centre, as `toward` of a shape.
fn toward_thing(object: Thing, at: vec2<f32>) -> vec2<f32> {
    let from_x = at.x - object.x;
    let from_y = at.y - object.y;
    if (object.kind == ROUND) {
        return vec2<f32>(-from_x, -from_y);
    }
    if (object.kind == BLOCK) {
        let own_x = from_x * object.unit_x + from_y * object.unit_y;
        let own_y = from_y * object.unit_x - from_x * object.unit_y;
        let beyond_x = own_x - clamp(own_x, -object.extent_x, object.extent_x);
        let beyond_y = own_y - clamp(own_y, -object.extent_y, object.extent_y);
        return vec2<f32>(
            beyond_y * object.unit_y - beyond_x * object.unit_x, -(beyond_x * object.unit_y) - beyond_y * object.unit_x,
        );
    }
    let along = clamp(from_x * object.extent_x + from_y * object.extent_y, 0.0f, 1.0f);
    return vec2<f32>(along * object.length_x - from_x, along * object.length_y - from_y);
}

// An object in the open, from a pose.
fn seen_alone(world: u32, object: Thing, pose: vec3<f32>) -> Lone {
    let to = toward_thing(object, vec2<f32>(pose.x, pose.y));
    let squared = squared_length(to);
    let inverse = reciprocal_root(max(squared, 0x1p-60f));
    let row = row_of(world, squared * inverse - object.contact);
    let bearing = bearing_of(world, pose.z, to, inverse);
    var alone = nothing_alone();
    alone.normal = cosine_sine(-f32(bearing) * reciprocal(worlds[world].bearings_per_turn));
    alone.distance = object.contact + (worlds[world].nearest + f32(row) * reciprocal(worlds[world].rows_per_mm));
    alone.kind = object.kind;
    alone.radius = object.extent_x;
    alone.reflectivity = object.reflectivity;
    if (object.kind == BLOCK) {
        alone.half = vec2<f32>(object.extent_x, object.extent_y);
        alone.views = object.views;
        let from_x = pose.x - object.x;
        let from_y = pose.y - object.y;
        alone.robot = vec2<f32>(
            from_x * object.unit_x + from_y * object.unit_y, from_y * object.unit_x - from_x * object.unit_y,
        );
        alone = viewed(alone);
    }
    return alone;
}

// The lowest of 64 bits.
fn lowest(bits: vec2<u32>) -> vec2<u32> {
    return vec2<u32>(bits.x & (0u - bits.x), select(0u, bits.y & (0u - bits.y), bits.x == 0u));
}

// What the sensors would read if every object stood alone in the open, at the next lower distance and bearing of the
// samples' grid, and readings of several objects were added: the simulator's picture.
//
// Few objects are in reach at once, though other lanes have others: so each turn takes every lane's next wall or
// block, and its next round object.
fn lone_readings(world: u32, pose: vec3<f32>, gain: f32) -> vec4<u32> {
    let first = worlds[world].first_shape;
    let count = shape_count(world);
    var flats = vec2<u32>(0u);
    var rounds = vec2<u32>(0u);
    for (var index = 0u; index < count; index++) {
        let shape = first + index;
        let squared = squared_length(toward(shape, vec2<f32>(pose.x, pose.y)));
        let gap = squared * reciprocal_root(max(squared, 0x1p-60f)) - shapes[shape].contact;
        let bit = select(0u, 1u << (index & 31u), row_of(world, gap) < worlds[world].rows);
        let bits = select(vec2<u32>(0u, bit), vec2<u32>(bit, 0u), index < 32u);
        if (shapes[shape].kind == ROUND) {
            rounds |= bits;
        } else {
            flats |= bits;
        }
    }
    var sums = vec4<u32>(0u);
    for (var turn = 0u; turn < count; turn++) {
        let next_flat = lowest(flats);
        let next_round = lowest(rounds);
        let is_flat = (next_flat.x | next_flat.y) != 0u;
        let is_round = (next_round.x | next_round.y) != 0u;
        if (!is_flat & !is_round) {
            break;
        }
        var flat = thing(first);
        var round = thing(first);
        var no_flat = true;
        var no_round = true;
        for (var index = 0u; index < count; index++) {
            let object = thing(first + index);
            if (object.kind == ROUND) {
                if (is_near(next_round, index) | no_round) {
                    round = object;
                }
                no_round = false;
            } else {
                if (is_near(next_flat, index) | no_flat) {
                    flat = object;
                }
                no_flat = false;
            }
        }
        sums += lone_reading(world, seen_alone(world, flat, pose), is_flat, seen_alone(world, round, pose), is_round, gain);
        flats ^= next_flat;
        rounds ^= next_round;
    }
    return sums;
}

// How much more light returns at a place than elsewhere: 1 and the sum of the field's waves.
fn illumination(world: u32, at: vec2<f32>) -> f32 {
    var gain = 1.0f;
    for (var wave = 0u; wave < WAVE_COUNT; wave++) {
        let term = wave_of(world, wave);
        gain += term.amplitude * cosine_sine(term.turns_x * at.x + term.turns_y * at.y + term.phase).x;
    }
    return max(gain, 0.0f);
}

// The integer that the robot gets: the simulator's picture, and of what the true one differs from it the share
// `geometry`, with the noise of reading, over the surroundings' light.
fn read_out(lone: u32, traced: u32, strength: SensingCell, word: u32) -> u32 {
    let summed = min(f32(lone) * READING, 1.0f);
    let seen = clamp(summed + strength.geometry * (f32(traced) * READING - summed), 0.0f, 1.0f);
    return whole(seen + strength.ambient + nearly_normal(word) * (strength.noise + strength.noise_share * seen));
}

// The robot's readings at the pose where it was when they were taken.
fn sense_by_rays(episode: Episode, step: u32, pose: vec3<f32>) -> Readings {
    let world = episode.world;
    let strength = sensing_of(world);
    let gain = illumination(world, vec2<f32>(pose.x, pose.y));
    var lone = vec4<u32>(0u);
    var traced = lone;
    if (strength.geometry != 1.0f) {
        lone = lone_readings(world, pose, gain);
    }
    if (strength.geometry != 0.0f) {
        traced = traced_readings(world, pose, gain);
    }
    let a = random_words(episode.key, STREAM_SENSOR, step, 0u);
    let b = random_words(episode.key, STREAM_SENSOR, step, 1u);
    let scale = worlds[world].reading_scale;
    return Readings(
        four_read_out(lone.xy, traced.xy, strength, a, scale),
        four_read_out(lone.zw, traced.zw, strength, b, scale),
        SensorReadings(),
    );
}

// Four of them, two in a word, as activations.
fn four_read_out(lone: vec2<u32>, traced: vec2<u32>, strength: SensingCell, words: vec4<u32>, scale: f32) -> vec4<f32> {
    return vec4<f32>(
        activation(read_out(lone.x & 0xffffu, traced.x & 0xffffu, strength, words.x), scale),
        activation(read_out(lone.x >> 16u, traced.x >> 16u, strength, words.y), scale),
        activation(read_out(lone.y & 0xffffu, traced.y & 0xffffu, strength, words.z), scale),
        activation(read_out(lone.y >> 16u, traced.y >> 16u, strength, words.w), scale),
    );
}
