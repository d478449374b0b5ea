// What parts that a user wrote may ask of the experiment; docs/extend.md lists it. It stands after the values of the parts, from
// GIVEN_CELL on, which is generated: a cell with the body's radius and the number of lights, and two cells for each light.

// Most lights of an arena, as GREATEST_LIST in src/world/differential.rs.
const GREATEST_LIGHTS: u32 = 64u;

// A light: where it stands and its height, mm; what a sensor that faces it reads from nearby; and what its distance is divided
// by, for robots with a model.
struct ArenaLight {
    place: vec2<f32>,
    height: f32,
    brightness: f32,
    intensity: f32,
}

fn given_numbers(episode: Episode, cell: u32) -> vec4<f32> {
    let words = tables[worlds[episode.world].own_values + GIVEN_CELL + cell];
    return vec4<f32>(bitcast<f32>(words.x), bitcast<f32>(words.y), bitcast<f32>(words.z), bitcast<f32>(words.w));
}

// Number of cycles of an episode that doesn't end early.
fn cycles(episode: Episode) -> u32 {
    return worlds[episode.world].steps;
}

// Radius of the body, mm.
fn body_radius(episode: Episode) -> f32 {
    return given_numbers(episode, 0u).x;
}

// Number of lights of the arena.
fn arena_lights(episode: Episode) -> u32 {
    return min(u32(given_numbers(episode, 0u).y), GREATEST_LIGHTS);
}

// A light by its number, from 0. Beyond the last it is the last; where there is none, all is 0.
fn arena_light(episode: Episode, light: u32) -> ArenaLight {
    let last = max(arena_lights(episode), 1u) - 1u;
    let cell = 1u + 2u * min(light, last);
    let place = given_numbers(episode, cell);
    return ArenaLight(place.xy, place.z, place.w, given_numbers(episode, cell + 1u).x);
}
