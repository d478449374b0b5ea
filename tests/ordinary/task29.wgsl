// Phototaxis by position: several lamps, brightness with the inverse square.

struct Lamp {
    at: vec2<f32>,
    power: f32,
    height: f32,
}

const LAMPS = 3;

fn brightness(p: vec2<f32>) -> f32 {
    var lamps = array<Lamp, LAMPS>(
        Lamp(vec2<f32>(150.0, 850.0), 1.0, 100.0),
        Lamp(vec2<f32>(850.0, 700.0), 0.6, 80.0),
        Lamp(vec2<f32>(600.0, 120.0), 0.3, 120.0),
    );
    var sum = 0.0;
    for (var i = 0; i < LAMPS; i++) {
        let lamp = lamps[i];
        let d = p - lamp.at;
        let h2 = lamp.height * lamp.height;
        sum += lamp.power * h2 / (dot(d, d) + h2);
    }
    return sum;
}

struct TaskState {
    brightest: f32,
    average: f32,
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let light = brightness(now.end.xy);
    let change = light - brightness(now.start.xy);

    var state = before;
    state.brightest = max(state.brightest, light);
    state.average += (light - state.average) / f32(now.step + 1u);

    let moving = sign(now.moved.left + now.moved.right);
    let reward = light + 10.0 * change + 0.01 * moving;
    return Reward(select(reward, 0.0, now.collided), state);
}
