// Softmax mixture of fixed behaviours; the genes weigh them by the readings.

const BEHAVIOURS = 5u;
const PER_BEHAVIOUR = INPUTS + 1u;
const CONTROLLER_GENES: u32 = BEHAVIOURS * PER_BEHAVIOUR + 1u;

const BEHAVIOUR_MOTORS = array<vec2<f32>, 5>(
    vec2<f32>(1.0, 1.0),   // forward
    vec2<f32>(0.2, 0.8),   // turn left
    vec2<f32>(0.8, 0.2),   // turn right
    vec2<f32>(0.1, 0.1),   // back
    vec2<f32>(0.5, 0.5),   // stop
);

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var score: array<f32, BEHAVIOURS>;
    var highest = -1e30;
    for (var b = 0u; b < BEHAVIOURS; b++) {
        let start = b * PER_BEHAVIOUR;
        score[b] = gene(episode, start + INPUTS);
        for (var i = 0u; i < INPUTS; i++) {
            score[b] += gene(episode, start + i) * reading(readings, i);
        }
        highest = max(highest, score[b]);
    }

    let sharpness = exp2(2.0 * gene(episode, BEHAVIOURS * PER_BEHAVIOUR));
    var sum = 0.0;
    var outputs = vec2<f32>(0.0);
    for (var b = 0u; b < BEHAVIOURS; b++) {
        let weight = exp((score[b] - highest) * sharpness);
        sum += weight;
        outputs += weight * BEHAVIOUR_MOTORS[b];
    }
    outputs /= sum;
    return Command(outputs, before);
}
