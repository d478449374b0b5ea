// The network of Kheperax: five inputs, eight rectified units, two outputs by the hyperbolic tangent.

const UNITS: u32 = 8u;
// Genes of a unit: a weight per input, a bias, and its weights to the left and the right wheel. The biases of the two come last.
const UNIT_GENES: u32 = 8u;
const CONTROLLER_GENES: u32 = UNITS * UNIT_GENES + 2u;

// The range of a laser in sides of the maze.
const RANGE: f32 = 0.2f;

// Kheperax reads the bumpers before the move that precedes the lasers' readings, so that they are a step older.
struct ControllerState {
    bumpers: vec2<f32>,
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let now = vec2<f32>(readings.bump_right, readings.bump_left);
    let bumpers = 2.0f * select(before.bumpers, now, step == 0u) - vec2<f32>(1.0f, 1.0f);
    let right = measured(readings.right);
    let ahead = measured(readings.ahead);
    let left = measured(readings.left);
    let biases = UNITS * UNIT_GENES;
    var sums = vec2<f32>(gene(episode, biases), gene(episode, biases + 1u));
    for (var unit = 0u; unit < UNITS; unit++) {
        let first = unit * UNIT_GENES;
        var input = gene(episode, first) * right + gene(episode, first + 1u) * ahead + gene(episode, first + 2u) * left;
        input += gene(episode, first + 3u) * bumpers.x + gene(episode, first + 4u) * bumpers.y + gene(episode, first + 5u);
        let output = max(input, 0.0f);
        sums.x += gene(episode, first + 6u) * output;
        sums.y += gene(episode, first + 7u) * output;
    }
    // A wheel's speed is tanh(x) = 2 logistic(2 x) - 1 of the greatest, and an output of 1/2 is a standstill.
    return Command(vec2<f32>(logistic(2.0f * sums.x), logistic(2.0f * sums.y)), ControllerState(now));
}

// A laser's reading in sides of the maze; -1 if nothing is in range.
fn measured(share: f32) -> f32 {
    return select(RANGE * share, -1.0f, share >= 1.0f);
}
