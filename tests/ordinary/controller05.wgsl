// Motor value as a Catmull-Rom curve over the balance of left and right readings.
const KNOTS: u32 = 6u;
const CONTROLLER_GENES: u32 = 2u * KNOTS + INPUTS;

fn catmull_rom(p: vec4<f32>, t: f32) -> f32 {
    let t2 = t * t;
    let t3 = t2 * t;
    return 0.5 * dot(p, vec4<f32>(-t3 + 2.0 * t2 - t,
                                  3.0 * t3 - 5.0 * t2 + 2.0,
                                  -3.0 * t3 + 4.0 * t2 + t,
                                  t3 - t2));
}

fn curve(episode: Episode, first: u32, x: f32) -> f32 {
    var knots: array<f32, KNOTS>;
    for (var k = 0u; k < KNOTS; k++) {
        knots[k] = gene(episode, first + k);
    }
    let scaled = clamp(x, 0.0, 0.9999) * f32(KNOTS - 1u);
    let segment = u32(floor(scaled));
    let t = fract(scaled);
    let p0 = knots[max(segment, 1u) - 1u];
    let p1 = knots[segment];
    let p2 = knots[min(segment + 1u, KNOTS - 1u)];
    let p3 = knots[min(segment + 2u, KNOTS - 1u)];
    return clamp(catmull_rom(vec4<f32>(p0, p1, p2, p3), t), 0.0, 1.0);
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var balance = 0.0;
    var norm = 0.001;
    for (var i = 0u; i < INPUTS; i++) {
        let w = gene(episode, 2u * KNOTS + i) * 2.0 - 1.0;
        balance += w * reading(readings, i);
        norm += abs(w);
    }
    let x = 0.5 + 0.5 * balance / norm;
    return Command(vec2<f32>(curve(episode, 0u, x), curve(episode, KNOTS, x)), before);
}
