// A Catmull-Rom spline maps the weighted sum of readings to each motor.

const KNOTS = 7u;
const PER_MOTOR = INPUTS + 1u + KNOTS;
const CONTROLLER_GENES: u32 = 2u * PER_MOTOR;

fn catmull_rom(p: vec4<f32>, t: f32) -> f32 {
    let t2 = t * t;
    let t3 = t2 * t;
    return 0.5 * (2.0 * p.y
        + (p.z - p.x) * t
        + (2.0 * p.x - 5.0 * p.y + 4.0 * p.z - p.w) * t2
        + (3.0 * p.y - p.x - 3.0 * p.z + p.w) * t3);
}

fn motor_curve(episode: Episode, start: u32, x: f32) -> f32 {
    var knots: array<f32, KNOTS>;
    for (var k = 0u; k < KNOTS; k++) {
        knots[k] = gene(episode, start + k);
    }
    let place = saturate(x) * f32(KNOTS - 1u);
    let i = min(i32(floor(place)), i32(KNOTS) - 2);
    let last = i32(KNOTS) - 1;
    let p = vec4<f32>(
        knots[max(i - 1, 0)],
        knots[i],
        knots[min(i + 1, last)],
        knots[min(i + 2, last)],
    );
    return catmull_rom(p, place - f32(i));
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var outputs = vec2<f32>(0.5);
    for (var m = 0u; m < 2u; m++) {
        let start = m * PER_MOTOR;
        var x = gene(episode, start + INPUTS);
        for (var i = 0u; i < INPUTS; i++) {
            x += gene(episode, start + i) * reading(readings, i);
        }
        // squash to 0..1 before looking up the curve
        x = 0.5 + 0.5 * x / (1.0 + abs(x));
        outputs[m] = saturate(0.5 + 0.5 * motor_curve(episode, start + INPUTS + 1u, x));
    }
    return Command(outputs, before);
}
