// Braitenberg vehicle with habituation: a slow average of the two drives is
// taken off, so that only changes go through in the long run.

const CONTROLLER_GENES: u32 = 2u * INPUTS + 4u;

struct ControllerState {
    slow: vec2<f32>,
    excitement: f32,
}

fn drives(episode: Episode, readings: Readings) -> vec2<f32> {
    var sum = vec2<f32>(0.0);
    for (var i = 0u; i < INPUTS; i = i + 1u) {
        let reading = reading(readings, i);
        let same = gene(episode, i);
        let crossed = gene(episode, INPUTS + i);
        let weights = select(vec2<f32>(crossed, same), vec2<f32>(same, crossed), i * 2u < INPUTS);
        sum += weights * reading;
    }
    return sum;
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let own = 2u * INPUTS;
    let base_speed = gene(episode, own);
    let adaptation = saturate(abs(gene(episode, own + 1u)));
    let rate = 0.001 + 0.05 * abs(gene(episode, own + 2u));

    let fast = drives(episode, readings);
    let slow = mix(before.slow, fast, rate);
    let fresh = fast - adaptation * slow;

    // Strong changes make the vehicle hurry for a while.
    let excitement = max(before.excitement * 0.95, length(fresh));
    let hurry = gene(episode, own + 3u) * smoothstep(0.2, 1.5, excitement);

    let motors = base_speed + hurry + fresh;
    let outputs = clamp(motors * 0.5 + vec2<f32>(0.5), vec2<f32>(0.0), vec2<f32>(1.0));
    return Command(outputs, ControllerState(slow, excitement));
}
