// What the kernels share whose rollouts are lives of one robot: who lives, where a life starts, and its trace.

// One line of a trace: the pose at the start of a cycle, what was perceived there, and what came of it.
struct Record {
    x: f32,
    y: f32,
    heading: f32,
    // where the readings are from: the pose, or where noise or age displaces it to
    seen_x: f32,
    seen_y: f32,
    // the readings as perceived
    sensor_0: f32,
    sensor_1: f32,
    sensor_2: f32,
    sensor_3: f32,
    sensor_4: f32,
    sensor_5: f32,
    sensor_6: f32,
    sensor_7: f32,
    // the same before sensor noise; of a forager, whose reward depends on none, 0
    real_0: f32,
    real_1: f32,
    real_2: f32,
    real_3: f32,
    real_4: f32,
    real_5: f32,
    real_6: f32,
    real_7: f32,
    left: f32,
    right: f32,
    speed_left: f32,
    speed_right: f32,
    collided: f32,
    reward: f32,
    fitness: f32,
    // of a forager: what it does, and 1 if it carries food
    behaviour: f32,
    carries: f32,
}

@group(0) @binding(6) var<storage, read_write> state: array<State>;
@group(0) @binding(8) var<storage, read_write> trace: array<Record>;

// Who lives: the world, the key of its random numbers, and the index of its first gene.
struct Life {
    world: u32,
    key: vec2<u32>,
    genes: u32,
}

// Where a life starts: x and y in mm, heading in turns.
fn first_pose(life: Life) -> vec3<f32> {
    if (worlds[life.world].random_start != 0u) {
        return random_pose(life);
    }
    return vec3<f32>(worlds[life.world].start_x, worlds[life.world].start_y, worlds[life.world].start_heading);
}

// A free pose, uniform over the world's field and all headings. Of 64 draws none being free leaves the
// world's own free pose, found when the world was made.
fn random_pose(life: Life) -> vec3<f32> {
    let world = life.world;
    var pose = vec3<f32>(worlds[world].start_x, worlds[world].start_y, worlds[world].start_heading);
    for (var draw = 0u; draw < 64u; draw++) {
        let u = units(random_words(life.key, STREAM_START, 0u, draw));
        let at = vec2<f32>(
            worlds[world].field_x + u.x * worlds[world].field_width,
            worlds[world].field_y + u.y * worlds[world].field_height,
        );
        if (!touches(world, at)) {
            pose = vec3<f32>(at, u.z);
            break;
        }
    }
    return pose;
}
