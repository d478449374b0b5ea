// A probabilistic finite state machine of AutoMoDe's modules: up to four states, each one of six behaviours, and up to four
// transitions from each, each by one of six conditions (modules.wgsl). src/parts/automode/state_machine.rs has the genes' names.

const STATES: u32 = 4u;
const TRANSITIONS: u32 = 4u;

// Genes: the number of states; of each state its behaviour, the behaviour's two values and the number of transitions; and of each
// transition where to, its condition, and the condition's three values.
const TRANSITION_GENES: u32 = 5u;
const STATE_GENES: u32 = 4u + TRANSITIONS * TRANSITION_GENES;
const CONTROLLER_GENES: u32 = 1u + STATES * STATE_GENES;

// Blocks of random numbers: whether each condition holds, and the order of those that do.
const CHANCES: u32 = 0u;
const ORDER: u32 = 1u;

struct ControllerState {
    // the state that acts next
    state: u32,
    // cycles that it has acted
    age: u32,
    // cycles that exploration still turns: counter-clockwise if positive
    turning: i32,
}

// The state after a cycle: of the conditions that hold, each with its probability, a random one decides.
fn next_state(episode: Episode, step: u32, now: u32, first: u32, readings: Readings) -> u32 {
    let others = whole_gene(episode, 0u, 1.0f, 4.0f) - 1u;
    let count = select(whole_gene(episode, first + 3u, 0.0f, 4.0f), 0u, others == 0u);
    let drawn = random(episode, STREAM_CONTROLLER, step, CHANCES);
    let order = random(episode, STREAM_CONTROLLER, step, ORDER);
    var chances = array<f32, 4>(drawn.x, drawn.y, drawn.z, drawn.w);
    var places = array<f32, 4>(order.x, order.y, order.z, order.w);
    var next = now;
    var place = 1.0f;
    for (var nth = 0u; nth < TRANSITIONS; nth++) {
        let transition = first + 4u + nth * TRANSITION_GENES;
        if ((nth < count) & (places[nth] < place)) {
            if (chances[nth] < probability(episode, transition + 1u, readings)) {
                let share = clamp(gene(episode, transition), 0.0f, 1.0f);
                let other = min(u32(share * f32(others)), others - 1u);
                next = other + select(0u, 1u, other >= now);
                place = places[nth];
            }
        }
    }
    return next;
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let first = 1u + before.state * STATE_GENES;
    // A state that is entered begins anew.
    let acted = behave(episode, step, first, readings, select(before.turning, 0, before.age == 0u));
    var next = before.state;
    // Conditions are not asked in a state's first cycle.
    if (before.age > 0u) {
        next = next_state(episode, step, before.state, first, readings);
    }
    let age = select(0u, before.age + 1u, next == before.state);
    return Command(0.5f + 0.5f * acted.wheels, ControllerState(next, age, acted.turning));
}
