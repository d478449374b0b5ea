// A probabilistic finite state machine of AutoMoDe's modules: up to four states, each one of six behaviours, and up to four
// transitions from each, each by one of six conditions. docs/controllers.md has the modules and where they are from;
// src/state_machine.rs has the genes' names.

const STATES: u32 = 4u;
const TRANSITIONS: u32 = 4u;

// Genes: the number of states; of each state its behaviour, the behaviour's two values and the number of transitions; and of each
// transition where to, its condition, and the condition's three values.
const TRANSITION_GENES: u32 = 5u;
const STATE_GENES: u32 = 4u + TRANSITIONS * TRANSITION_GENES;
const CONTROLLER_GENES: u32 = 1u + STATES * STATE_GENES;

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

// Blocks of random numbers: whether each condition holds, the order of those that do, and how long exploration turns.
const CHANCES: u32 = 0u;
const ORDER: u32 = 1u;
const TURNING: u32 = 2u;

struct ControllerValues {
    obstacle: f32, // 0.1, 0 to 10: length of the vector of proximity from which on exploration turns away
    avoidance: f32, // 5, 0 to 100: weight of that vector in phototaxis, anti-phototaxis and repulsion
    attraction_avoidance: f32, // 6, 0 to 100: the same in attraction
    least_vector: f32, // 0.1, 0.001 to 10: robots drive straight ahead instead of along shorter vectors
    slowest_wheel: f32, // -0.5, -1 to 1: the inner wheel's least speed in a curve, as a share of the outer one's
}

struct ControllerState {
    // the state that acts next
    state: u32,
    // cycles that it has acted
    age: u32,
    // cycles that exploration still turns: counter-clockwise if positive
    turning: i32,
}

fn whole_gene(life: Life, index: u32, least: f32, greatest: f32) -> u32 {
    return u32(clamp(floor(gene(life, index)), least, greatest));
}

// Speeds of the wheels, as shares of the greatest, along a vector.
fn along(own: ControllerValues, v: vec2<f32>) -> vec2<f32> {
    let squared = squared_length(v);
    if (squared < own.least_vector * own.least_vector) {
        return vec2<f32>(1.0f, 1.0f);
    }
    let inner = max(own.slowest_wheel, v.x * reciprocal_root(squared));
    return select(vec2<f32>(1.0f, inner), vec2<f32>(inner, 1.0f), v.y > 0.0f);
}

// For how many cycles exploration will turn, which is 0 while it goes straight ahead.
fn turned_away(life: Life, step: u32, first: u32, own: ControllerValues, near: vec2<f32>) -> i32 {
    if ((squared_length(near) < own.obstacle * own.obstacle) | (near.x < 0.0f)) {
        return 0;
    }
    let most = whole_gene(life, first + 1u, 1.0f, 100.0f);
    let share = random(life, STREAM_CONTROLLER, step, TURNING).x;
    // A turn of no cycles takes one.
    let cycles = i32(clamp(u32(share * f32(most + 1u)), 1u, most));
    return select(-cycles, cycles, near.y < 0.0f);
}

// The probability of a condition.
fn probability(life: Life, first: u32, readings: Readings) -> f32 {
    let condition = whole_gene(life, first + 1u, 0.0f, 5.0f);
    let fixed = clamp(gene(life, first + 2u), 0.0f, 1.0f);
    let more = readings.neighbours - f32(whole_gene(life, first + 3u, 0.0f, 10.0f));
    let steepness = clamp(gene(life, first + 4u), 0.0f, 20.0f);
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

// The state after a cycle: of the conditions that hold, each with its probability, a random one decides.
fn next_state(life: Life, step: u32, now: u32, first: u32, readings: Readings) -> u32 {
    let others = whole_gene(life, 0u, 1.0f, 4.0f) - 1u;
    let count = select(whole_gene(life, first + 3u, 0.0f, 4.0f), 0u, others == 0u);
    let drawn = random(life, STREAM_CONTROLLER, step, CHANCES);
    let order = random(life, STREAM_CONTROLLER, step, ORDER);
    var chances = array<f32, 4>(drawn.x, drawn.y, drawn.z, drawn.w);
    var places = array<f32, 4>(order.x, order.y, order.z, order.w);
    var next = now;
    var place = 1.0f;
    for (var nth = 0u; nth < TRANSITIONS; nth++) {
        let own = first + 4u + nth * TRANSITION_GENES;
        if ((nth < count) & (places[nth] < place)) {
            if (chances[nth] < probability(life, own, readings)) {
                let share = clamp(gene(life, own), 0.0f, 1.0f);
                let other = min(u32(share * f32(others)), others - 1u);
                next = other + select(0u, 1u, other >= now);
                place = places[nth];
            }
        }
    }
    return next;
}

fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    let own = controller_values(life);
    let first = 1u + before.state * STATE_GENES;
    let behaviour = whole_gene(life, first, 0.0f, 5.0f);
    let near = vec2<f32>(readings.prox_ahead, readings.prox_left);
    let light = vec2<f32>(readings.light_ahead, readings.light_left);
    var wheels = vec2<f32>(1.0f, 1.0f);
    // A state that is entered begins anew.
    var turning = select(before.turning, 0, before.age == 0u);
    if (behaviour == EXPLORATION) {
        if (turning == 0) {
            turning = turned_away(life, step, first, own, near);
        } else {
            wheels = select(vec2<f32>(1.0f, -1.0f), vec2<f32>(-1.0f, 1.0f), turning > 0);
            turning = select(turning + 1, turning - 1, turning > 0);
        }
    } else if (behaviour == STOP) {
        wheels = vec2<f32>(0.0f, 0.0f);
    } else if (behaviour == PHOTOTAXIS) {
        wheels = along(own, light - own.avoidance * near);
    } else if (behaviour == ANTI_PHOTOTAXIS) {
        wheels = along(own, -light - own.avoidance * near);
    } else {
        let strength = clamp(gene(life, first + 2u), 1.0f, 5.0f);
        let toward_others = strength * vec2<f32>(readings.attraction_ahead, readings.attraction_left);
        if (behaviour == ATTRACTION) {
            wheels = along(own, toward_others - own.attraction_avoidance * near);
        } else {
            wheels = along(own, -toward_others - own.avoidance * near);
        }
    }
    var next = before.state;
    // Conditions are not asked in a state's first cycle.
    if (before.age > 0u) {
        next = next_state(life, step, before.state, first, readings);
    }
    let age = select(0u, before.age + 1u, next == before.state);
    return Command(0.5f + 0.5f * wheels, ControllerState(next, age, turning));
}
