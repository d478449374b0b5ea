// PID to the heading at which the readings are weakest (the free direction).
const CONTROLLER_GENES: u32 = 4u;
const PI = 3.14159265;

struct ControllerState {
    integral: f32,
    last_error: f32,
}

// Direction of the obstacles, as seen from the robot, in radians.
fn free_heading(readings: Readings) -> f32 {
    var sum = vec2<f32>(0.001, 0.0);
    for (var i = 0u; i < INPUTS; i++) {
        let angle = PI * (f32(i) + 0.5) / f32(INPUTS) - PI / 2.0;
        sum += (1.0 - reading(readings, i)) * vec2<f32>(cos(angle), sin(angle));
    }
    let direction = normalize(sum);
    return atan2(direction.y, direction.x);
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let kp = 2.0 * gene(episode, 0u);
    let ki = 0.1 * gene(episode, 1u);
    let kd = 4.0 * gene(episode, 2u);
    let cruise = 0.3 + 0.5 * gene(episode, 3u);

    let error = free_heading(readings) / PI;
    let integral = clamp(before.integral * 0.98 + error, -5.0, 5.0);
    var derivative = 0.0;
    if step > 0u {
        derivative = error - before.last_error;
    }
    let turn = clamp(kp * error + ki * integral + kd * derivative, -1.0, 1.0);
    let speed = cruise * (1.0 - 0.5 * abs(turn));
    let outputs = clamp(vec2<f32>(speed - turn, speed + turn), vec2<f32>(0.0), vec2<f32>(1.0));
    return Command(outputs, ControllerState(integral, error));
}
