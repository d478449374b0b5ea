// A controller: how readings and genes become commands of the two motors, in each cycle of 100 ms. Change it as you like;
// `oneiro check` says what is wrong, and where. docs/extend.md lists all that a controller may use.
//
// As it stands: each motor sums all readings by its genes, and follows the sum slowly, by a gene of its own.

// INPUTS is the number of readings. Genes: for each motor a weight per reading, a bias, and its pace.
const CONTROLLER_GENES: u32 = 2u * (INPUTS + 2u);

// What the controller remembers during a life; all zero at its start.
struct ControllerState {
    sums: vec2<f32>,
}

// The commands of a cycle to the left and the right motor, 0 to 1, and what the controller remembers of it.
fn controller_cycle(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    let left = followed(life, 0u, readings, before.sums.x);
    let right = followed(life, INPUTS + 2u, readings, before.sums.y);
    return Command(vec2<f32>(logistic(left), logistic(right)), ControllerState(vec2<f32>(left, right)));
}

// A motor's sum after a cycle, given the index of its first gene and the sum before.
fn followed(life: Life, first: u32, readings: Readings, before: f32) -> f32 {
    let sum = weighed(life, first, readings) + gene(life, first + INPUTS);
    let pace = logistic(gene(life, first + INPUTS + 1u));
    return before + pace * (sum - before);
}
