// What a swarm's world keeps, and where: a block of words for the world, one for each robot and then one for each item of food,
// LANES worlds side by side, so that the same word of neighbouring worlds is next to it.

// Words of the world: how much food was brought in all.
const HARVESTED: u32 = 0u;
const WORLD_WORDS: u32 = 1u;

// Words of each item of food: where it lies, and while robots ask for it in a cycle, which of them gets it, and the square of that
// one's distance.
const ITEM_X: u32 = 0u;
const ITEM_Y: u32 = 1u;
const ITEM_OWNER: u32 = 2u;
const ITEM_SQUARED: u32 = 3u;
const ITEM_WORDS: u32 = 4u;

// Words of each robot.
const X: u32 = 0u;
const Y: u32 = 1u;
const HEADING: u32 = 2u;
// its random numbers, two words
const KEY: u32 = 3u;
// fitness of this interval, when that began, and food brought since the last line of the trace
const EARNED: u32 = 5u;
const SINCE: u32 = 6u;
const BROUGHT: u32 = 7u;
const CARRIES: u32 = 8u;
// what its behaviours remember, and which acts
const ESCAPE: u32 = 9u;
const STRAIGHT: u32 = 10u;
const TURN: u32 = 11u;
const WAIT: u32 = 12u;
const BEHAVIOUR: u32 = 13u;
// what it wanted to do a cycle ago: forward and turn
const WANTED: u32 = 14u;
// where it gets to in this cycle while bodies push each other, by turns in one and the other: x and y each
const PUSHED: u32 = 16u;
// whom it has heard since the last line, a bit each
const HEARD: u32 = 20u;
// how it differs from others: two wheels, four sensors of proximity, eight of light
const WHEELS: u32 = 24u;
const NEAR_GAINS: u32 = 26u;
const LIGHT_GAINS: u32 = 30u;
const ROBOT_WORDS: u32 = 38u;

// Words of a robot in a line of the trace. LINE_DOES is its behaviour, with bits from LINE_CARRIES on for whether it
// carries food, and from LINE_BROUGHT on how much it brought. A bit for each robot that it heard comes after; after all
// robots each item's x and y.
const LINE_X: u32 = 0u;
const LINE_Y: u32 = 1u;
const LINE_HEADING: u32 = 2u;
const LINE_DOES: u32 = 3u;
const LINE_EARNED: u32 = 4u;
const LINE_WORDS: u32 = 5u;
const LINE_CARRIES: u32 = 3u;
const LINE_BROUGHT: u32 = 4u;
const LINE_ITEM_WORDS: u32 = 2u;

// Cells of a swarm's world besides a forager's.
const MEETING: u32 = FORAGER_CELLS;
const DELAYS: u32 = FORAGER_CELLS + 1u;
const FIELD: u32 = FORAGER_CELLS + 2u;
const SPREAD: u32 = FORAGER_CELLS + 3u;
// the key of the robots' differences, two words
const WHO: u32 = FORAGER_CELLS + 4u;
const SWARM_CELLS: u32 = FORAGER_CELLS + 5u;

// How messages are heard.
struct MeetingCell {
    squared_range: f32,
    // chance that one is
    heard: f32,
    // 1 if bodies are in the way
    line_of_sight: f32,
    unused_a: f32,
}

fn meeting_of(world: u32) -> MeetingCell {
    let cell = numbers(world, MEETING);
    return MeetingCell(cell.x, cell.y, cell.z, cell.w);
}

// What goes wrong.
struct DelaysCell {
    // cycles from sensors to wheels, 0 or 1
    latency: f32,
    // at the most
    slip: f32,
    // chance of no word from the tracking
    tracking_loss: f32,
    unused_a: f32,
}

fn delays_of(world: u32) -> DelaysCell {
    let cell = numbers(world, DELAYS);
    return DelaysCell(cell.x, cell.y, cell.z, cell.w);
}

// How the light differs from place to place.
struct FieldCell {
    // how much darker it is off the axis of the lamp
    beam: f32,
    // light thrown back by the walls
    reflection: f32,
    // share of light that a body takes
    shadows: f32,
    unused_a: f32,
}

fn field_of(world: u32) -> FieldCell {
    let cell = numbers(world, FIELD);
    return FieldCell(cell.x, cell.y, cell.z, cell.w);
}

// Standard deviations of what differs between robots.
struct SpreadCell {
    wheels: f32,
    proximity: f32,
    light: f32,
    unused_a: f32,
}

fn spread_of(world: u32) -> SpreadCell {
    let cell = numbers(world, SPREAD);
    return SpreadCell(cell.x, cell.y, cell.z, cell.w);
}

// Inputs of a world after its key: which side the lamp is on (-1 over the nest, 0 nowhere, 1 opposite), on which side
// later, and from which step on; then of each robot the genes that it has, those that it gets, and when; and when its
// interval begins. A robot whose first gene is below 0 is not switched on.
const LAMP_FIRST: u32 = 0u;
const LAMP_THEN: u32 = 1u;
const LAMP_MOVES: u32 = 2u;
const ORDERS: u32 = 3u;
const ORDER_BEFORE: u32 = 0u;
const ORDER_AFTER: u32 = 2u;
const ORDER_AT: u32 = 4u;
const ORDER_BEGINS: u32 = 5u;
const ORDER_WORDS: u32 = 6u;

// Cycles of a second.
const SECOND: u32 = 10u;

@group(0) @binding(6) var<storage, read_write> state: array<u32>;
@group(0) @binding(8) var<storage, read_write> trace: array<u32>;

// An episode: the world, the key of its random numbers and the index of its first gene; and of a robot among others
// where its words are and what surrounds it.
struct Episode {
    world: u32,
    key: vec2<u32>,
    genes: u32,
    robot_words: u32,
    // how far the nearest other is before each of the four sensors at the front, mm
    others: vec4<f32>,
    // the side of the lamp, and which share of its light gets here
    lamp: f32,
    share: f32,
}

fn input(index: u32) -> f32 {
    return bitcast<f32>(inputs[index]);
}

fn gene(episode: Episode, index: u32) -> f32 {
    return input(episode.genes + index * LANES);
}

fn word(words: u32, field: u32) -> u32 {
    return state[words + field * LANES];
}

fn number(words: u32, field: u32) -> f32 {
    return bitcast<f32>(state[words + field * LANES]);
}

fn put(words: u32, field: u32, value: f32) {
    state[words + field * LANES] = bitcast<u32>(stored(value));
}

fn robots(world: u32) -> u32 {
    return min(u32(arena_of(world).robots), GREATEST_ROBOTS);
}

fn items(world: u32) -> u32 {
    return min(u32(arena_of(world).items), GREATEST_ITEMS);
}

// Where a robot's words are, given where its world's are.
fn robot_at(base: u32, robot: u32) -> u32 {
    return base + (WORLD_WORDS + robot * ROBOT_WORDS) * LANES;
}

// Where an item's words are.
fn food_at(base: u32, world: u32, item: u32) -> u32 {
    return robot_at(base, robots(world)) + item * ITEM_WORDS * LANES;
}
