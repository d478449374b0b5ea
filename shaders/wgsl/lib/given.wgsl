// What parts that a user wrote may ask of the world and of the experiment; docs/extend.md lists it. It stands after the values of
// the parts, from GIVEN_CELL on, which is generated, in the order of `given` in src/world/given.rs. Places and sizes are in mm.

// Most elements of a list, as GREATEST_OBJECTS in src/world/arena.rs has it.
const GREATEST_GIVEN: u32 = 4096u;
// Where the numbers of these lists and their first cells are.
const GIVEN_LISTS: u32 = 2u;
const GIVEN_LIGHTS: u32 = 0u;
const GIVEN_PATCHES: u32 = 1u;
const GIVEN_WALLS: u32 = 2u;
const GIVEN_OBSTACLES: u32 = 3u;
const GIVEN_BLOCKS: u32 = 4u;

// A light: where it stands and its height; what a sensor that faces it reads from nearby; and what its distance is divided
// by, for robots with a model.
struct ArenaLight {
    place: vec2<f32>,
    height: f32,
    brightness: f32,
    intensity: f32,
}

// A patch of the floor: its middle; its radius, or half of its sides and the direction of the first, a unit vector; its grey.
struct ArenaPatch {
    place: vec2<f32>,
    radius: f32,
    half_sides: vec2<f32>,
    along: vec2<f32>,
    grey: f32,
}

// A wall, by its ends.
struct ArenaWall {
    start: vec2<f32>,
    end: vec2<f32>,
}

// A round obstacle.
struct ArenaObstacle {
    place: vec2<f32>,
    radius: f32,
}

// A block: its middle, half of its sides, and the direction of the first, a unit vector.
struct ArenaBlock {
    place: vec2<f32>,
    half_sides: vec2<f32>,
    along: vec2<f32>,
}

// The rectangle around the floor.
struct ArenaField {
    low: vec2<f32>,
    high: vec2<f32>,
}

fn given_numbers(episode: Episode, cell: u32) -> vec4<f32> {
    let words = tables[worlds[episode.world].own_values + GIVEN_CELL + cell];
    return vec4<f32>(bitcast<f32>(words.x), bitcast<f32>(words.y), bitcast<f32>(words.z), bitcast<f32>(words.w));
}

// The number of elements of a list.
fn given_count(episode: Episode, list: u32) -> u32 {
    return min(u32(given_numbers(episode, GIVEN_LISTS + list).x), GREATEST_GIVEN);
}

// The first cell of an element. Beyond the last it is the last; where there is none, it is a cell of zeros.
fn given_element(episode: Episode, list: u32, index: u32) -> u32 {
    let head = given_numbers(episode, GIVEN_LISTS + list);
    let last = max(u32(head.x), 1u) - 1u;
    return u32(head.y) + u32(head.z) * min(index, last);
}

// Number of cycles of an episode that doesn't end early.
fn cycles(episode: Episode) -> u32 {
    return u32(given_numbers(episode, 0u).w);
}

// The number of the episode among those of its genome in a generation, from 0.
fn trial(episode: Episode) -> u32 {
    return episode.trial;
}

// Number of robots in the world, and the number of the robot that this is, from 0.
fn robots(episode: Episode) -> u32 {
    return 1u;
}

fn robot_number(episode: Episode) -> u32 {
    return 0u;
}

// Radius of the body.
fn body_radius(episode: Episode) -> f32 {
    return given_numbers(episode, 0u).x;
}

fn arena_field(episode: Episode) -> ArenaField {
    let field = given_numbers(episode, 1u);
    return ArenaField(field.xy, field.zw);
}

// Each list of the arena: how many elements it has, and an element by its number, from 0. Beyond the last it is the last; where
// there is none, all is 0.
fn arena_lights(episode: Episode) -> u32 {
    return given_count(episode, GIVEN_LIGHTS);
}

fn arena_light(episode: Episode, light: u32) -> ArenaLight {
    let cell = given_element(episode, GIVEN_LIGHTS, light);
    let place = given_numbers(episode, cell);
    return ArenaLight(place.xy, place.z, place.w, given_numbers(episode, cell + 1u).x);
}

fn arena_patches(episode: Episode) -> u32 {
    return given_count(episode, GIVEN_PATCHES);
}

fn arena_patch(episode: Episode, patch_number: u32) -> ArenaPatch {
    let cell = given_element(episode, GIVEN_PATCHES, patch_number);
    let place = given_numbers(episode, cell);
    let size = given_numbers(episode, cell + 1u);
    return ArenaPatch(place.xy, size.z, size.xy, place.zw, size.w);
}

fn arena_walls(episode: Episode) -> u32 {
    return given_count(episode, GIVEN_WALLS);
}

fn arena_wall(episode: Episode, wall: u32) -> ArenaWall {
    let ends = given_numbers(episode, given_element(episode, GIVEN_WALLS, wall));
    return ArenaWall(ends.xy, ends.zw);
}

fn arena_obstacles(episode: Episode) -> u32 {
    return given_count(episode, GIVEN_OBSTACLES);
}

fn arena_obstacle(episode: Episode, obstacle: u32) -> ArenaObstacle {
    let disc = given_numbers(episode, given_element(episode, GIVEN_OBSTACLES, obstacle));
    return ArenaObstacle(disc.xy, disc.z);
}

fn arena_blocks(episode: Episode) -> u32 {
    return given_count(episode, GIVEN_BLOCKS);
}

fn arena_block(episode: Episode, block: u32) -> ArenaBlock {
    let cell = given_element(episode, GIVEN_BLOCKS, block);
    let place = given_numbers(episode, cell);
    return ArenaBlock(place.xy, given_numbers(episode, cell + 1u).xy, place.zw);
}

// Whether a place is on a patch of the floor.
fn on_patch(episode: Episode, patch_number: u32, at: vec2<f32>) -> bool {
    let found = arena_patch(episode, patch_number);
    let away = vec2<f32>(at.x - found.place.x, at.y - found.place.y);
    let along = abs(away.x * found.along.x + away.y * found.along.y);
    let across = abs(away.y * found.along.x - away.x * found.along.y);
    let is_round = squared_length(away) < found.radius * found.radius;
    let is_within = (along <= found.half_sides.x) & (across <= found.half_sides.y) & (found.radius == 0.0f);
    return (is_round | is_within) & (patch_number < arena_patches(episode));
}

// Whether a place is on a patch of the floor other than this one.
fn on_other_patch(episode: Episode, patch_number: u32, at: vec2<f32>) -> bool {
    var is_on = false;
    for (var other = 0u; other < arena_patches(episode); other++) {
        is_on = is_on | ((other != patch_number) & on_patch(episode, other, at));
    }
    return is_on;
}

// The grey of the floor at a place, from 0 for black to 1 for white: that of the last patch there.
fn floor_at(episode: Episode, place: vec2<f32>) -> f32 {
    return given_grey(episode, place, given_numbers(episode, 0u).y);
}

// The grey of the last patch at a place; `beyond` where there is none.
fn given_grey(episode: Episode, place: vec2<f32>, beyond: f32) -> f32 {
    var grey = beyond;
    for (var patch_number = 0u; patch_number < arena_patches(episode); patch_number++) {
        let patch_grey = arena_patch(episode, patch_number).grey;
        grey = select(grey, patch_grey, on_patch(episode, patch_number, place));
    }
    return grey;
}

// The gap between a robot's body and the nearest wall, obstacle or block if its centre is at a place; negative where they overlap,
// and `most` if nothing is nearer.
fn clearance(episode: Episode, at: vec2<f32>, most: f32) -> f32 {
    let first = worlds[episode.world].first_shape;
    let end = first + shape_count(episode.world);
    var gap = most;
    for (var shape = first; shape < end; shape++) {
        gap = min(gap, root(squared_length(toward(shape, at))) - shapes[shape].contact);
    }
    return gap;
}
