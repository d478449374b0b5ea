// An e-puck among others, which are in its way and in its light, and no two of which are alike.

// How far the nearest thing is before each of the four sensors at the front, and what share of the lamp's light
// others leave. Reflected light comes from as far off an axis as the sensor's beam is wide.
fn among(before: Episode, base: u32, robot: u32, pose: vec3<f32>) -> Episode {
    const BEAM: f32 = 0.25f;
    var episode = before;
    let world = episode.world;
    let body = robot_of(world).radius;
    let sight = 2.0f * body + sensing_of(world).sight;
    let directions = axes(world, 0u, pose.z);
    let lamp = vec2<f32>(episode.lamp * lamp_of(world).x, 0.0f);
    let way = vec2<f32>(lamp.x - pose.x, lamp.y - pose.y);
    let lamp_inverse = reciprocal_root(max(squared_length(way), 1.0f));
    let to_lamp = vec2<f32>(way.x * lamp_inverse, way.y * lamp_inverse);
    let to_lamp_distance = squared_length(way) * lamp_inverse;
    let body_inverse = reciprocal(2.0f * body);
    var others = vec4<f32>(0x1p17f);
    var shade = 0.0f;
    let count = robots(world);
    for (var block = 0u; block < count; block += 32u) {
        var near = 0u;
        for (var other = block; other < min(block + 32u, count); other++) {
            if (other != robot) {
                let at = robot_at(base, other);
                let x = number(at, X) - pose.x;
                let y = number(at, Y) - pose.y;
                near |= select(0u, 1u << (other & 31u), x * x + y * y < sight * sight);
                // As if the lamp were far away: all of the light if the two are in line with it, none from two radii off on.
                let along = x * to_lamp.x + y * to_lamp.y;
                let aside = abs(y * to_lamp.x - x * to_lamp.y);
                let taken = clamp(1.0f - aside * body_inverse, 0.0f, 1.0f);
                shade = max(shade, select(0.0f, taken, (along > 0.0f) & (along < to_lamp_distance)));
            }
        }
        // Few others are near, and every lane has others near: each turn takes every lane's next one.
        for (var turn = 0u; turn < 32u; turn++) {
            if (near == 0u) {
                break;
            }
            let at = robot_at(base, block + lowest_bit(near));
            near &= near - 1u;
            let x = number(at, X) - pose.x;
            let y = number(at, Y) - pose.y;
            let squared = x * x + y * y;
            let gap = max(root(max(squared, 0x1p-60f)) - 2.0f * body, 0.0f);
            let along = x * directions.x + y * directions.y;
            let aside = abs(y * directions.x - x * directions.y);
            let seen = (along > vec4<f32>(0.0f)) & (aside < body + BEAM * along);
            others = min(others, select(vec4<f32>(0x1p17f), vec4<f32>(gap), seen));
        }
    }
    let field = field_of(world);
    // The lamp looks towards the centre.
    let off_axis = to_lamp.y * to_lamp.y;
    episode.others = others;
    episode.share = (1.0f - field.shadows * shade) * (1.0f - field.beam * off_axis);
    return episode;
}

// What the four sensors at the front read of the wall and of others, in [0, 1].
fn near(episode: Episode, step: u32, pose: vec3<f32>) -> vec4<f32> {
    let read = near_readings(episode, step, min(wall_distances(episode.world, pose), episode.others));
    return clamp(four(episode.robot_words, NEAR_GAINS) * read, vec4<f32>(0.0f), vec4<f32>(1.0f));
}

// What four sensors read of the light, in [0, 1].
fn light(episode: Episode, step: u32, half: u32, pose: vec3<f32>) -> vec4<f32> {
    var shine = vec4<f32>(0.0f);
    if (episode.lamp != 0.0f) {
        let arena = arena_of(episode.world).radius;
        let direct = lamp_light(episode.world, half, pose, vec2<f32>(episode.lamp * lamp_of(episode.world).x, 0.0f));
        // The walls' reflected light comes from everywhere, and more of it near the lamp.
        let nearness = 0.5f + 0.5f * clamp(episode.lamp * pose.x * reciprocal(arena), -1.0f, 1.0f);
        shine = episode.share * direct + field_of(episode.world).reflection * nearness;
    }
    return light_readings(episode, step, half, four(episode.robot_words, LIGHT_GAINS + 4u * half) * shine);
}

// What each wheel makes of a command.
fn wheels(episode: Episode) -> vec2<f32> {
    return vec2<f32>(number(episode.robot_words, WHEELS), number(episode.robot_words, WHEELS + 1u));
}

// Draws how a robot differs from others.
fn differ(world: u32, robot_words: u32, robot: u32) {
    let words = tables[worlds[world].numbers + WHO];
    let spread = spread_of(world);
    put_four(robot_words, NEAR_GAINS, gains(words.xy, robot, 0u, spread.proximity));
    put_four(robot_words, LIGHT_GAINS, gains(words.xy, robot, 1u, spread.light));
    put_four(robot_words, LIGHT_GAINS + 4u, gains(words.xy, robot, 2u, spread.light));
    let wheel = gains(words.xy, robot, 3u, spread.wheels);
    put(robot_words, WHEELS, wheel.x);
    put(robot_words, WHEELS + 1u, wheel.y);
}

// Four gains around 1.
fn gains(key: vec2<u32>, robot: u32, block: u32, deviation: f32) -> vec4<f32> {
    let words = random_words(key, STREAM_START, robot, block);
    return 1.0f + deviation * vec4<f32>(
        nearly_normal(words.x), nearly_normal(words.y), nearly_normal(words.z), nearly_normal(words.w),
    );
}

fn four(words: u32, field: u32) -> vec4<f32> {
    return vec4<f32>(
        number(words, field), number(words, field + 1u), number(words, field + 2u), number(words, field + 3u),
    );
}

fn put_four(words: u32, field: u32, values: vec4<f32>) {
    put(words, field, values.x);
    put(words, field + 1u, values.y);
    put(words, field + 2u, values.z);
    put(words, field + 3u, values.w);
}
