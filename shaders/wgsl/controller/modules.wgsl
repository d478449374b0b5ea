// AutoMoDe's modules for e-pucks: six behaviours, and six conditions that hold with a probability. docs/controllers.md has them and
// where they are from; src/parts/automode.rs has the genes' names and ranges. State machines and behaviour trees are put together from them.

const EXPLORATION: u32 = 0u;
const STOP: u32 = 1u;
const PHOTOTAXIS: u32 = 2u;
const ANTI_PHOTOTAXIS: u32 = 3u;
const ATTRACTION: u32 = 4u;

const BLACK_FLOOR: u32 = 0u;
const GREY_FLOOR: u32 = 1u;
const WHITE_FLOOR: u32 = 2u;
const NEIGHBOUR_COUNT: u32 = 3u;
const INVERTED_NEIGHBOUR_COUNT: u32 = 4u;

// The block of random numbers for how long exploration turns.
const TURNING: u32 = 2u;

struct ControllerValues {
    obstacle: f32, // 0.1, 0 to 10: length of the vector of proximity from which on exploration turns away
    avoidance: f32, // 5, 0 to 100: weight of that vector in phototaxis, anti-phototaxis and repulsion
    attraction_avoidance: f32, // 6, 0 to 100: the same in attraction
    least_vector: f32, // 0.1, 0.001 to 10: robots drive straight ahead instead of along shorter vectors
    slowest_wheel: f32, // -0.5, -1 to 1: the inner wheel's minimum speed in a curve, as a fraction of the outer one's
}

struct Acted {
    // speeds of the wheels, as fractions of the maximum
    wheels: vec2<f32>,
    // cycles that exploration still turns: counter-clockwise if positive
    turning: i32,
}

fn whole_gene(episode: Episode, index: u32, least: f32, greatest: f32) -> u32 {
    return u32(clamp(floor(gene(episode, index)), least, greatest));
}

// Speeds of the wheels, as fractions of the maximum, along a vector.
fn along(values: ControllerValues, v: vec2<f32>) -> vec2<f32> {
    let squared = squared_length(v);
    if (squared < values.least_vector * values.least_vector) {
        return vec2<f32>(1.0f, 1.0f);
    }
    let inner = max(values.slowest_wheel, v.x * reciprocal_root(squared));
    return select(vec2<f32>(1.0f, inner), vec2<f32>(inner, 1.0f), v.y > 0.0f);
}

// For how many cycles exploration will turn, which is 0 while it goes straight ahead.
fn turned_away(episode: Episode, step: u32, first: u32, values: ControllerValues, near: vec2<f32>) -> i32 {
    if ((squared_length(near) < values.obstacle * values.obstacle) | (near.x < 0.0f)) {
        return 0;
    }
    let most = whole_gene(episode, first + 1u, 1.0f, 100.0f);
    let share = random(episode, STREAM_CONTROLLER, step, TURNING).x;
    // A turn of no cycles takes one.
    let cycles = i32(clamp(u32(share * f32(most + 1u)), 1u, most));
    return select(-cycles, cycles, near.y < 0.0f);
}

// What a behaviour does, from its first gene on: which one, and its two values.
fn behave(episode: Episode, step: u32, first: u32, readings: Readings, before: i32) -> Acted {
    let values = controller_values(episode);
    let behaviour = whole_gene(episode, first, 0.0f, 5.0f);
    let near = vec2<f32>(readings.prox_ahead, readings.prox_left);
    let light = vec2<f32>(readings.light_ahead, readings.light_left);
    var wheels = vec2<f32>(1.0f, 1.0f);
    var turning = before;
    if (behaviour == EXPLORATION) {
        if (turning == 0) {
            turning = turned_away(episode, step, first, values, near);
        } else {
            wheels = select(vec2<f32>(1.0f, -1.0f), vec2<f32>(-1.0f, 1.0f), turning > 0);
            turning = select(turning + 1, turning - 1, turning > 0);
        }
    } else if (behaviour == STOP) {
        wheels = vec2<f32>(0.0f, 0.0f);
    } else if (behaviour == PHOTOTAXIS) {
        wheels = along(values, light - values.avoidance * near);
    } else if (behaviour == ANTI_PHOTOTAXIS) {
        wheels = along(values, -light - values.avoidance * near);
    } else {
        let strength = clamp(gene(episode, first + 2u), 1.0f, 5.0f);
        let toward_others = strength * vec2<f32>(readings.attraction_ahead, readings.attraction_left);
        if (behaviour == ATTRACTION) {
            wheels = along(values, toward_others - values.attraction_avoidance * near);
        } else {
            wheels = along(values, -toward_others - values.avoidance * near);
        }
    }
    return Acted(wheels, turning);
}

// The probability of a condition, from its first gene on: which one, and its three values.
fn probability(episode: Episode, first: u32, readings: Readings) -> f32 {
    let condition = whole_gene(episode, first, 0.0f, 5.0f);
    let fixed = clamp(gene(episode, first + 1u), 0.0f, 1.0f);
    let more = readings.neighbours - f32(whole_gene(episode, first + 2u, 0.0f, 10.0f));
    let steepness = clamp(gene(episode, first + 3u), 0.0f, 20.0f);
    if (condition == NEIGHBOUR_COUNT) {
        return logistic(steepness * more);
    }
    if (condition == INVERTED_NEIGHBOUR_COUNT) {
        return logistic(-steepness * more);
    }
    let ground = readings.ground;
    let is_black = ground < 0.25f;
    let is_white = ground > 0.75f;
    if (((condition == BLACK_FLOOR) & !is_black) | ((condition == WHITE_FLOOR) & !is_white)
        | ((condition == GREY_FLOOR) & (is_black | is_white))) {
        return 0.0f;
    }
    return fixed;
}
