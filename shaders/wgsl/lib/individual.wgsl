// A surrogate robot and its surroundings: numbers for its sensors and wheels, in cells of `tables`
// from `worlds[..].numbers` on. Each cell's struct says what is in it.

// Of each sensor three cells: where it is and looks, its pairs of rays' weights, and its curve.
const SENSOR_CELLS: u32 = 3u;
const PLACE: u32 = 0u;
const RAY_WEIGHTS: u32 = 1u;
const CURVE: u32 = 2u;
const WAVES: u32 = 24u;
const WAVE_COUNT: u32 = 4u;
const SENSING: u32 = 28u;
const TIMING: u32 = 29u;
const WHEELS: u32 = 30u;
const INDIVIDUAL_CELLS: u32 = 31u;

// Where a sensor is on the body (mm) and where it looks, in the robot's frame.
struct PlaceCell {
    x: f32,
    y: f32,
    axis_x: f32,
    axis_y: f32,
}

fn place_of(world: u32, sensor: u32) -> PlaceCell {
    let cell = numbers(world, sensor * SENSOR_CELLS + PLACE);
    return PlaceCell(cell.x, cell.y, cell.z, cell.w);
}

// A sensor's curve: where it reads half of the maximum, mm, and how steeply its logistic falls there, per mm.
struct CurveCell {
    half: f32,
    steepness: f32,
    unused_a: f32,
    unused_b: f32,
}

fn curve_of(world: u32, sensor: u32) -> CurveCell {
    let cell = numbers(world, sensor * SENSOR_CELLS + CURVE);
    return CurveCell(cell.x, cell.y, cell.z, cell.w);
}

// A wave of the illumination.
struct WaveCell {
    // per mm
    turns_x: f32,
    turns_y: f32,
    // turns
    phase: f32,
    amplitude: f32,
}

fn wave_of(world: u32, wave: u32) -> WaveCell {
    let cell = numbers(world, WAVES + wave);
    return WaveCell(cell.x, cell.y, cell.z, cell.w);
}

// How much of the true geometry is in the readings, their noise alone and in proportion to them, and the light of the
// surroundings.
struct SensingCell {
    geometry: f32,
    noise: f32,
    noise_share: f32,
    ambient: f32,
}

fn sensing_of(world: u32) -> SensingCell {
    let cell = numbers(world, SENSING);
    return SensingCell(cell.x, cell.y, cell.z, cell.w);
}

// Minimum age of readings, and the range above it, in cycles; and the parts of its motion.
struct TimingCell {
    latency: f32,
    period: f32,
    // 0: a cycle goes along its first heading, as in the simulator; 1: along an arc
    arc: f32,
    // share of what a robot that is stopped does nevertheless: slide along and turn
    slip: f32,
}

fn timing_of(world: u32) -> TimingCell {
    let cell = numbers(world, TIMING);
    return TimingCell(cell.x, cell.y, cell.z, cell.w);
}

struct WheelsCell {
    // speed of a wheel at its maximum command, mm/s
    full_left: f32,
    full_right: f32,
    // turns per mm that the right wheel goes farther than the left
    turns_per_mm: f32,
    // share of the difference between command and speed that 20 ms make up for
    response: f32,
}

fn wheels_of(world: u32) -> WheelsCell {
    let cell = numbers(world, WHEELS);
    return WheelsCell(cell.x, cell.y, cell.z, cell.w);
}
