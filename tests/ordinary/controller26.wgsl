// Subsumption: the highest layer that is triggered takes the motors.

const LAYERS = 4u;
const CONTROLLER_GENES: u32 = LAYERS * 3u;

const WANDER = 0u;
const CRUISE = 1u;
const AVOID = 2u;
const RETREAT = 3u;

struct ControllerState {
    layer: u32,
    since: u32,
}

fn strongest(readings: Readings) -> f32 {
    var most = 0.0;
    for (var i = 0u; i < INPUTS; i++) {
        most = max(most, reading(readings, i));
    }
    return most;
}

fn balance(readings: Readings) -> f32 {
    var left = 0.0;
    var right = 0.0;
    for (var i = 0u; i < INPUTS; i++) {
        let value = reading(readings, i);
        if (i < INPUTS / 2u) { left += value; } else { right += value; }
    }
    return left - right;
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let peak = strongest(readings);
    let side = balance(readings);

    var layer = WANDER;
    if (peak > 0.1) { layer = CRUISE; }
    if (peak > 0.3 + 0.2 * gene(episode, 0u)) { layer = AVOID; }
    if (peak > 0.8 + 0.1 * gene(episode, 1u)) { layer = RETREAT; }
    // once retreating, keep on for a few cycles
    if (before.layer == RETREAT && before.since < 8u) { layer = RETREAT; }

    let g = vec3<f32>(
        gene(episode, layer * 3u), gene(episode, layer * 3u + 1u), gene(episode, layer * 3u + 2u));
    var wheels: vec2<f32>;
    switch layer {
        case CRUISE: {
            wheels = vec2<f32>(0.6 + 0.4 * g.y);
        }
        case AVOID: {
            let turn = sign(side) * (0.3 + abs(g.y));
            wheels = vec2<f32>(turn, -turn) + 0.2 * g.z;
        }
        case RETREAT: {
            wheels = vec2<f32>(-0.7, -0.4) * (1.0 + 0.3 * g.yz);
        }
        default: {
            let r = random(episode, STREAM_CONTROLLER, step / 10u, 0u);
            wheels = mix(g.xy, 2.0 * r.xy - 1.0, 0.5);
        }
    }

    let since = select(0u, before.since + 1u, layer == before.layer);
    let outputs = clamp(wheels * 0.5 + 0.5, vec2<f32>(0.0), vec2<f32>(1.0));
    return Command(outputs, ControllerState(layer, since));
}
