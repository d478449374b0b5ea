// Sugeno fuzzy controller: 3 x 3 rules over "left side" and "right side".
const SETS: u32 = 3u;
const CONTROLLER_GENES: u32 = SETS * SETS * 2u + 2u;

fn triangle(x: f32, center: f32, width: f32) -> f32 {
    return max(0.0, 1.0 - abs(x - center) / width);
}

fn memberships(x: f32, middle: f32) -> vec3<f32> {
    let near = smoothstep(middle, 1.0, x);
    let far = 1.0 - smoothstep(0.0, middle, x);
    let medium = triangle(x, middle, 0.5);
    return vec3<f32>(far, medium, near);
}

fn side(readings: Readings, parity: u32) -> f32 {
    var strongest = 0.0;
    for (var i = parity; i < INPUTS; i += 2u) {
        strongest = max(strongest, reading(readings, i));
    }
    return strongest;
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let rules = SETS * SETS * 2u;
    let a = memberships(side(readings, 0u), mix(0.2, 0.8, gene(episode, rules)));
    let b = memberships(side(readings, 1u), mix(0.2, 0.8, gene(episode, rules + 1u)));
    var sum = vec2f(0.0);
    var weight_sum = 0.0001;
    for (var i = 0u; i < SETS; i++) {
        for (var j = 0u; j < SETS; j++) {
            let strength = min(a[i], b[j]);
            if (strength <= 0.0) {
                continue;
            }
            let index = (i * SETS + j) * 2u;
            sum += strength * vec2f(gene(episode, index), gene(episode, index + 1u));
            weight_sum += strength;
        }
    }
    return Command(sum / weight_sum, before);
}
