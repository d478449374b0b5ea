// How a parametric robot in its surroundings differs from its description: numbers in cells from DIFFERENCE_CELL on. Each cell's struct
// says what is in it. The differences of single sensors are in their own cells.

const WAVE_COUNT: u32 = 4u;
const READING_CELL: u32 = 4u;
const MOVING_CELL: u32 = 5u;
const WHEEL_CELL: u32 = 6u;

// A wave of the illumination: its turns per mm, its phase in turns, and its amplitude.
fn wave_of(world: u32, wave: u32) -> vec4<f32> {
    return numbers(world, DIFFERENCE_CELL + wave);
}

// The noise of readings, alone and in proportion to them; the light of the surroundings; and the minimum age of readings, in
// cycles.
struct ReadingCell {
    noise: f32,
    noise_share: f32,
    ambient: f32,
    latency: f32,
}

fn reading_cell(world: u32) -> ReadingCell {
    let cell = numbers(world, DIFFERENCE_CELL + READING_CELL);
    return ReadingCell(cell.x, cell.y, cell.z, cell.w);
}

struct MovingCell {
    // up to how many cycles older readings are
    period: f32,
    // of the wheels' deviation from the commanded motion: the fraction left after a cycle, and the mean over it
    left_over: f32,
    mean: f32,
    // share of what a stopped robot does nevertheless of sliding along and turning
    slip: f32,
}

fn moving_cell(world: u32) -> MovingCell {
    let cell = numbers(world, DIFFERENCE_CELL + MOVING_CELL);
    return MovingCell(cell.x, cell.y, cell.z, cell.w);
}

// The wheels' mean excess of speed, and half of the right wheel's excess over the left one: as
// mm of the way for each turn, and as turns for each mm.
struct WheelCell {
    mean: f32,
    way: f32,
    turn: f32,
    unused: f32,
}

fn wheel_cell(world: u32) -> WheelCell {
    let cell = numbers(world, DIFFERENCE_CELL + WHEEL_CELL);
    return WheelCell(cell.x, cell.y, cell.z, cell.w);
}

// How much more light is at a place than elsewhere: 1 and the sum of the field's waves.
fn illumination(world: u32, at: vec2<f32>) -> f32 {
    var gain = 1.0f;
    for (var wave = 0u; wave < WAVE_COUNT; wave++) {
        let term = wave_of(world, wave);
        gain += term.w * cosine_sine(term.x * at.x + term.y * at.y + term.z).x;
    }
    return max(gain, 0x1p-10f);
}

// The fraction of a distance at which an object seems to be in so much more light: what returns falls with the distance's square.
fn seeming_share(gain: f32) -> f32 {
    return select(reciprocal_root(gain), 1.0f, gain == 1.0f);
}

// How much farther than its range a proximity sensor may see.
const GREATEST_SIGHT: f32 = 2.1f;

fn with_farther_sight(sensor: SensorCell) -> SensorCell {
    return SensorCell(sensor.heading, sensor.offset, GREATEST_SIGHT * sensor.range, sensor.share);
}

// What a ray leaves free, the sensor's offset included, if distances from the sensor seem so much shorter or longer.
fn seemingly_free(sensor: SensorCell, free: f32, share: f32) -> f32 {
    return select(sensor.offset + (free - sensor.offset) * share, free, share == 1.0f);
}

// A reading with its noise, over the light of the surroundings.
fn read_with_noise(cell: ReadingCell, reading: f32, ambient: f32, word: u32) -> f32 {
    return clamp(reading + ambient + nearly_normal(word) * (cell.noise + cell.noise_share * reading), 0.0f, 1.0f);
}

// How old readings are, in cycles: of the latency and, since sensors are read on their own clock, up to a period more.
fn age_of_readings(episode: Episode, step: u32) -> f32 {
    let moving = moving_cell(episode.world);
    // Beyond the draws of the noise of 64 sensors.
    let early = unit(random_words(episode.key, STREAM_SENSOR, step, 16u).x);
    return min(reading_cell(episode.world).latency + moving.period * early, 1.0f);
}

// A number that follows another one a cycle long: what it is then, and its mean.
fn lagging(moving: MovingCell, number: f32, goal: f32) -> vec2<f32> {
    let away = flushed(number - goal);
    return vec2<f32>(goal + away * moving.left_over, goal + away * moving.mean);
}

// Displacement and turn of wheels that are not quite equal.
fn by_unlike_wheels(world: u32, displacement: f32, turn: f32) -> vec2<f32> {
    let wheel = wheel_cell(world);
    return vec2<f32>(
        displacement + (wheel.mean * displacement + wheel.way * turn), turn + (wheel.mean * turn + wheel.turn * displacement),
    );
}
