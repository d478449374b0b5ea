// A continuous-time recurrent network of five units, all connected, of which the first two drive the motors:
// y' = y + h / tau (-y + sum of w o + sum of inputs), then o = logistic(y + theta), all y before any o (Beer).
//
// Genes, each in [-16, 16]: for each unit a weight per reading, the weights of the five units, its bias theta, and its time
// constant, tau = 0.1 s * 50^((gene + 16) / 32), from 0.1 to 5 s; 85 with ten readings.

const UNITS: u32 = 5u;
const UNIT_GENES: u32 = INPUTS + UNITS + 2u;
const CONTROLLER_GENES: u32 = UNITS * UNIT_GENES;

struct ControllerState {
    first: vec4<f32>,
    last: f32,
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var y = array<f32, 5>(before.first.x, before.first.y, before.first.z, before.first.w, before.last);
    var outputs = array<f32, 5>();
    for (var unit = 0u; unit < UNITS; unit++) {
        outputs[unit] = logistic(y[unit] + theta(episode, unit));
    }
    for (var unit = 0u; unit < UNITS; unit++) {
        let first = unit * UNIT_GENES;
        var sum = weighed(episode, first, readings);
        for (var other = 0u; other < UNITS; other++) {
            sum += gene(episode, first + INPUTS + other) * outputs[other];
        }
        y[unit] += rate(gene(episode, first + INPUTS + UNITS + 1u)) * (sum - y[unit]);
    }
    let command = vec2<f32>(logistic(y[0] + theta(episode, 0u)), logistic(y[1] + theta(episode, 1u)));
    return Command(command, ControllerState(vec4<f32>(y[0], y[1], y[2], y[3]), y[4]));
}

fn theta(episode: Episode, unit: u32) -> f32 {
    return gene(episode, unit * UNIT_GENES + INPUTS + UNITS);
}

// h / tau for a cycle h of 0.1 s: 50^-((gene + 16) / 32). The logarithm of 50 is 3.912023.
fn rate(gene: f32) -> f32 {
    return exponential(-3.912023f * clamp((gene + 16.0f) * 0.03125f, 0.0f, 1.0f));
}
