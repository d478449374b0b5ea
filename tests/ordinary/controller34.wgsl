// Potential field: each reading pushes along its own direction, a random
// drift pulls, and the sum is turned into wheel speeds.

const PI = 3.141592653589793;
const CONTROLLER_GENES: u32 = 2u * INPUTS + 3u;
const DRIFT_CYCLES = 25u;

struct ControllerState {
    force: vec2<f32>,
}

fn unit(angle: f32) -> vec2<f32> {
    return vec2<f32>(cos(angle), sin(angle));
}

fn drift(episode: Episode, step: u32) -> vec2<f32> {
    let block = step / DRIFT_CYCLES;
    let t = f32(step % DRIFT_CYCLES) / f32(DRIFT_CYCLES);
    let a = random(episode, STREAM_CONTROLLER, block, 0u).x - 0.5;
    let b = random(episode, STREAM_CONTROLLER, block + 1u, 0u).x - 0.5;
    return unit(mix(a, b, smoothstep(0.0, 1.0, t)) * PI);
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var force = vec2<f32>(0.5 + gene(episode, 2u * INPUTS), 0.0);
    for (var i = 0u; i < INPUTS; i++) {
        let angle = PI * gene(episode, 2u * i);
        let strength = gene(episode, 2u * i + 1u);
        force -= strength * pow(reading(readings, i), 2.0) * unit(angle);
    }
    force += gene(episode, 2u * INPUTS + 1u) * drift(episode, step);

    let inertia = clamp(abs(gene(episode, 2u * INPUTS + 2u)), 0.0, 0.9);
    force = mix(force, before.force, inertia);

    let size = length(force);
    var direction = vec2<f32>(1.0, 0.0);
    if (size > 0.0001) {
        direction = force / size;
    }
    let bearing = atan2(direction.y, direction.x) / PI;
    let speed = min(size, 1.0) * max(direction.x, 0.0);
    let wheels = vec2<f32>(speed - bearing, speed + bearing);
    return Command(saturate(wheels * 0.5 + 0.5), ControllerState(force));
}
