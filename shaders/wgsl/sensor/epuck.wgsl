// Eight infra-red sensors of an e-puck in a circular arena: proximity by the sensors' measured curve, and the light of
// one lamp. What a robot senses in all, `robot/epuck_alone` and `robot/epuck_among` say.

// Four sensors' axes in the world: those at the front, or the others.
struct Axes {
    x: vec4<f32>,
    y: vec4<f32>,
}

fn axes(world: u32, half: u32, heading: f32) -> Axes {
    let cosines = numbers(world, AXES + 2u * half);
    let sines = numbers(world, AXES + 2u * half + 1u);
    let ahead = cosine_sine(heading);
    return Axes(ahead.x * cosines - ahead.y * sines, ahead.y * cosines + ahead.x * sines);
}

// How far the wall is along the axes of the four sensors at the front, mm.
fn wall_distances(world: u32, pose: vec3<f32>) -> vec4<f32> {
    let directions = axes(world, 0u, pose.z);
    let body = robot_of(world).radius;
    let radius = arena_of(world).radius;
    let x = pose.x + body * directions.x;
    let y = pose.y + body * directions.y;
    let along = x * directions.x + y * directions.y;
    let beyond = max(along * along + (radius * radius - (x * x + y * y)), vec4<f32>(0.0f));
    return vec4<f32>(root(beyond.x), root(beyond.y), root(beyond.z), root(beyond.w)) - along;
}

// What the four sensors at the front read of things at these distances, in [0, 1].
fn near_readings(episode: Episode, step: u32, distances: vec4<f32>) -> vec4<f32> {
    let noise = random_words(episode.key, STREAM_SENSOR, step, 0u);
    return vec4<f32>(
        proximity(episode.world, distances.x, noise.x), proximity(episode.world, distances.y, noise.y),
        proximity(episode.world, distances.z, noise.z), proximity(episode.world, distances.w, noise.w),
    );
}

// The curve's value at a distance, with its noise.
fn proximity(world: u32, distance: f32, word: u32) -> f32 {
    let sensing = sensing_of(world);
    var reading = 0.0f;
    if (distance < sensing.sight) {
        let entry = u32(max(distance * sensing.entries_per_mm, 0.0f));
        let cell = curve_of(world, entry / 2u);
        let value = select(cell.next_reading, cell.reading, entry % 2u == 0u);
        let spread = select(cell.next_noise, cell.noise, entry % 2u == 0u);
        reading = clamp(value * (1.0f + spread * nearly_normal(word)), 0.0f, 1.0f);
    }
    return reading;
}

// What four sensors get of the light of a lamp, of 1: it fades with the distance and with the angle between lamp and
// axis.
fn lamp_light(world: u32, half: u32, pose: vec3<f32>, lamp: vec2<f32>) -> vec4<f32> {
    let directions = axes(world, half, pose.z);
    let body = robot_of(world).radius;
    let decay = lamp_of(world).decay;
    let x = lamp.x - (pose.x + body * directions.x);
    let y = lamp.y - (pose.y + body * directions.y);
    let second = lit(vec2<f32>(x.y, y.y), vec2<f32>(directions.x.y, directions.y.y), decay);
    let third = lit(vec2<f32>(x.z, y.z), vec2<f32>(directions.x.z, directions.y.z), decay);
    if (half == 1u) {
        // The first and the last look opposite ways: one of them at the most sees the lamp.
        let is_first = x.x * directions.x.x + y.x * directions.y.x >= 0.0f;
        let either = lit(
            vec2<f32>(select(x.w, x.x, is_first), select(y.w, y.x, is_first)),
            vec2<f32>(select(directions.x.w, directions.x.x, is_first), select(directions.y.w, directions.y.x, is_first)), decay,
        );
        return vec4<f32>(select(0.0f, either, is_first), second, third, select(either, 0.0f, is_first));
    }
    return vec4<f32>(
        lit(vec2<f32>(x.x, y.x), vec2<f32>(directions.x.x, directions.y.x), decay), second, third,
        lit(vec2<f32>(x.w, y.w), vec2<f32>(directions.x.w, directions.y.w), decay),
    );
}

// What they read of that, in [0, 1], over an ambient light and with noise.
fn light_readings(episode: Episode, step: u32, half: u32, shine: vec4<f32>) -> vec4<f32> {
    let sensing = sensing_of(episode.world);
    let noise = 2.0f * units(random_words(episode.key, STREAM_SENSOR, step, 1u + half)) - 1.0f;
    return clamp(shine + sensing.ambient + sensing.light_noise * noise, vec4<f32>(0.0f), vec4<f32>(1.0f));
}

// exp(-decay distance) max(0, 1 - 2 |angle| / pi): of a lamp that lies at `to` from a sensor that looks along `axis`.
fn lit(to: vec2<f32>, axis: vec2<f32>, decay: f32) -> f32 {
    let squared = max(squared_length(to), 0x1p-60f);
    let inverse = reciprocal_root(squared);
    // From the axis to the lamp, as a right-angled triangle.
    let ahead = to.x * axis.x + to.y * axis.y;
    let aside = abs(to.y * axis.x - to.x * axis.y);
    let turns = quarter_direction(abs(ahead), aside, inverse);
    let share = select(1.0f - 4.0f * turns, 0.0f, ahead < 0.0f);
    return exponential_within(max(-decay * squared * inverse, -80.0f)) * share;
}
