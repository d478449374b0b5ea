// A controller: how readings and genes become commands of the two motors, in each cycle of 100 ms. Change it as you like;
// `oneiro check` says what is wrong, and where. docs/extend.md lists all that a controller may use.
//
// As it stands: each motor sums all readings by its genes, and follows the sum slowly, by a gene of its own.

// The genes. INPUTS is the number of readings. Where a comment has a range, genes evolve in it.
struct ControllerGenes {
    to_left: array<f32, INPUTS>, // weights of the readings for the left motor
    to_right: array<f32, INPUTS>, // weights of the readings for the right motor
    biases: array<f32, 2>, // of the left and the right motor
    paces: array<f32, 2>, // 0.02 to 1: share of the way to its sum that a motor goes in a cycle
}

// What the controller remembers during an episode; all zero at its start.
struct ControllerState {
    sums: vec2<f32>,
}

// The commands of a cycle to the left and the right motor, 0 to 1, and what the controller remembers of it.
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let left = weighed(episode, TO_LEFT, readings) + gene(episode, BIASES);
    let right = weighed(episode, TO_RIGHT, readings) + gene(episode, BIASES + 1u);
    let sums = vec2<f32>(
        followed(before.sums.x, left, gene(episode, PACES)),
        followed(before.sums.y, right, gene(episode, PACES + 1u)),
    );
    return Command(vec2<f32>(logistic(sums.x), logistic(sums.y)), ControllerState(sums));
}

// A motor's sum after a cycle, given the one before.
fn followed(before: f32, sum: f32, pace: f32) -> f32 {
    return before + pace * (sum - before);
}
