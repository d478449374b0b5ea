// Continuous-time recurrent network, six neurons, Euler integration with substeps.
const N: u32 = 6u;
const SUBSTEPS: u32 = 4u;
const DT: f32 = 0.025;
const BIAS_AT: u32 = N * N;
const TAU_AT: u32 = BIAS_AT + N;
const INPUT_AT: u32 = TAU_AT + N;
const CONTROLLER_GENES: u32 = INPUT_AT + N * INPUTS;

struct ControllerState {
    a: vec3<f32>,
    b: vec3<f32>,
}

fn fire(x: f32) -> f32 {
    return 1.0 / (1.0 + exp(-x));
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var y = array<f32, N>(before.a.x, before.a.y, before.a.z, before.b.x, before.b.y, before.b.z);
    var drive: array<f32, N>;
    for (var n = 0u; n < N; n++) {
        var total = 0.0;
        for (var i = 0u; i < INPUTS; i++) {
            let w = gene(episode, INPUT_AT + n * INPUTS + i) * 10.0 - 5.0;
            total += w * reading(readings, i);
        }
        drive[n] = total;
    }
    for (var s = 0u; s < SUBSTEPS; s++) {
        var rate: array<f32, N>;
        for (var n = 0u; n < N; n++) {
            rate[n] = fire(y[n] + gene(episode, BIAS_AT + n) * 8.0 - 4.0);
        }
        for (var n = 0u; n < N; n++) {
            var sum = drive[n];
            for (var k = 0u; k < N; k++) {
                sum += (gene(episode, n * N + k) * 10.0 - 5.0) * rate[k];
            }
            let tau = 0.05 * pow(40.0, gene(episode, TAU_AT + n));
            y[n] += DT / tau * (sum - y[n]);
        }
    }
    let state = ControllerState(vec3<f32>(y[0], y[1], y[2]), vec3<f32>(y[3], y[4], y[5]));
    return Command(vec2<f32>(fire(y[N - 2u]), fire(y[N - 1u])), state);
}
