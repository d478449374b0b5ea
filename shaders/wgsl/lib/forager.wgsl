// A forager and its arena: numbers for its sensors, wheels, behaviours and task, in cells of
// `tables` from `worlds[..].numbers` on. Each cell's struct says what is in it. The arena is a circle around the origin.
// Lengths in mm, angles in turns, times in cycles.

const NEST: u32 = 0u;
const LAMP: u32 = 1u;
const SENSING: u32 = 2u;
const ROBOT: u32 = 3u;
const DRIVING: u32 = 4u;
const TIMES: u32 = 5u;
const ARENA: u32 = 6u;
const PHOTOTAXIS: u32 = 7u;
// cosines and sines of the bearings of the four sensors at the front, then of the others
const AXES: u32 = 8u;
const CURVE: u32 = 12u;
// The proximity sensors' curve has an entry each mm, two in a cell.
const CURVE_ENTRIES: u32 = 70u;
const FORAGER_CELLS: u32 = CURVE + CURVE_ENTRIES / 2u;

// Most items of food and most robots of a world.
const GREATEST_ITEMS: u32 = 64u;
const GREATEST_ROBOTS: u32 = 128u;

// The nest, and the food.
struct NestCell {
    x: f32,
    y: f32,
    squared_radius: f32,
    // how near an item is taken
    squared_reach: f32,
}

fn nest_of(world: u32) -> NestCell {
    let cell = numbers(world, NEST);
    return NestCell(cell.x, cell.y, cell.z, cell.w);
}

// The lamp; of a swarm as if it were opposite.
struct LampCell {
    x: f32,
    y: f32,
    // per mm
    decay: f32,
    // 1 if it does
    shines: f32,
}

fn lamp_of(world: u32) -> LampCell {
    let cell = numbers(world, LAMP);
    return LampCell(cell.x, cell.y, cell.z, cell.w);
}

// Light and proximity sensors.
struct SensingCell {
    ambient: f32,
    light_noise: f32,
    // range of the proximity sensors
    sight: f32,
    // of their curve
    entries_per_mm: f32,
}

fn sensing_of(world: u32) -> SensingCell {
    let cell = numbers(world, SENSING);
    return SensingCell(cell.x, cell.y, cell.z, cell.w);
}

// The body and its wheels.
struct RobotCell {
    radius: f32,
    // extra way of one wheel, and missing way of the other, in a turn on the spot
    half_turn_path: f32,
    // that a wheel goes in a cycle
    farthest: f32,
    wheel_noise: f32,
}

fn robot_of(world: u32) -> RobotCell {
    let cell = numbers(world, ROBOT);
    return RobotCell(cell.x, cell.y, cell.z, cell.w);
}

// What behaviours drive.
struct DrivingCell {
    cruise: f32,
    // on the spot
    turn: f32,
    // turn for each turn off the light
    gain: f32,
    // towards the light
    greatest_turn: f32,
}

fn driving_of(world: u32) -> DrivingCell {
    let cell = numbers(world, DRIVING);
    return DrivingCell(cell.x, cell.y, cell.z, cell.w);
}

// Times and thresholds of behaviours and of the task.
struct TimesCell {
    // after an escape
    straight: f32,
    // mean between random turns
    interval: f32,
    // a reading from which on something is near
    near: f32,
    // seconds in which food earns
    limit: f32,
}

fn times_of(world: u32) -> TimesCell {
    let cell = numbers(world, TIMES);
    return TimesCell(cell.x, cell.y, cell.z, cell.w);
}

// The arena.
struct ArenaCell {
    radius: f32,
    // s
    cycle: f32,
    // of food
    items: f32,
    robots: f32,
}

fn arena_of(world: u32) -> ArenaCell {
    let cell = numbers(world, ARENA);
    return ArenaCell(cell.x, cell.y, cell.z, cell.w);
}

// When phototaxis acts.
struct PhototaxisCell {
    // what the brightest light sensor must read for it to act; 0: it always acts
    threshold: f32,
    unused_a: f32,
    unused_b: f32,
    unused_c: f32,
}

fn phototaxis_of(world: u32) -> PhototaxisCell {
    let cell = numbers(world, PHOTOTAXIS);
    return PhototaxisCell(cell.x, cell.y, cell.z, cell.w);
}

// Two entries of the curve of the proximity sensors: reading and its relative noise, by distance.
struct CurveCell {
    reading: f32,
    noise: f32,
    next_reading: f32,
    next_noise: f32,
}

fn curve_of(world: u32, pair: u32) -> CurveCell {
    let cell = numbers(world, CURVE + pair);
    return CurveCell(cell.x, cell.y, cell.z, cell.w);
}
