// Noise of a robot sampled as a whole, beyond that of the kernels that ship: relative noise of readings, wheels that act late and veer,
// and noise that is drawn once for a whole episode. Its declarations replace the same names in other parts.

// The world's first cell of numbers.
struct VariedCell {
    // maximum fraction by which an activation is larger or smaller
    gain: f32,
    // maximum turn, in turns, for each mm of the way
    veer: f32,
    // maximum fraction of a cycle by which commands act late
    delay: f32,
    // 1 if an episode keeps what it draws first
    per_episode: f32,
}

fn varied(world: u32) -> VariedCell {
    let cell = numbers(world, 0u);
    return VariedCell(cell.x, cell.y, cell.z, cell.w);
}

// The cycle whose draws count in a cycle.
fn drawn_at(varied_cell: VariedCell, step: u32) -> u32 {
    return select(step, 0u, varied_cell.per_episode > 0.0f);
}

// The readings with the world's noise of sensors: each is multiplied by a number around 1, a number is added, and the sum clipped.
fn with_noise(episode: Episode, step: u32, readings: Readings) -> Readings {
    let noise = varied(episode.world);
    let at = drawn_at(noise, step);
    let low = worlds[episode.world].sensor_noise_low;
    let span = worlds[episode.world].sensor_noise_span;
    let added_first = units(random_words(episode.key, STREAM_SENSOR, at, 0u)) * span + low;
    let added_last = units(random_words(episode.key, STREAM_SENSOR, at, 1u)) * span + low;
    let gain_first = (2.0f * units(random_words(episode.key, STREAM_SENSOR, at, 2u)) - 1.0f) * noise.gain + 1.0f;
    let gain_last = (2.0f * units(random_words(episode.key, STREAM_SENSOR, at, 3u)) - 1.0f) * noise.gain + 1.0f;
    var noisy = readings;
    noisy.first = clamp(readings.first * gain_first + added_first, vec4<f32>(0.0f), vec4<f32>(1.0f));
    noisy.last = clamp(readings.last * gain_last + added_last, vec4<f32>(0.0f), vec4<f32>(1.0f));
    return noisy;
}

// What the robot remembers; all zero at the start of an episode.
struct RobotState {
    // 1 once a body that sticks has touched something
    stuck: u32,
    // the motion that was commanded in the cycle before
    displacement: f32,
    turn: f32,
}

fn robot_kept(robot: RobotState) -> RobotState {
    return RobotState(robot.stuck, stored(robot.displacement), stored(robot.turn));
}

// The motion for a pair of outputs (left, right). While a command is late the wheels go on as before. The wheels' speeds that a task
// gets are the commanded ones.
fn motion(episode: Episode, step: u32, outputs: vec2<f32>, before: RobotState) -> Driven {
    let cell = varied(episode.world);
    let draw = units(random_words(episode.key, STREAM_ACTUATOR, drawn_at(cell, step), 0u));
    let now = commanded(episode.world, outputs);
    let late = cell.delay * draw.w;
    let noise = worlds[episode.world].motor_noise;
    var moved = now;
    moved.displacement = now.displacement + late * (before.displacement - now.displacement);
    moved.turn = now.turn + late * (before.turn - now.turn);
    moved.displacement *= 1.0f + noise * (2.0f * draw.x - 1.0f);
    moved.turn *= 1.0f + noise * (2.0f * draw.y - 1.0f);
    moved.turn += cell.veer * (2.0f * draw.z - 1.0f) * moved.displacement;
    return Driven(moved, RobotState(before.stuck, now.displacement, now.turn));
}
