// The predator's camera: a line of pixels, of which five sectors say whether the prey is there, at any distance (Floreano and Nolfi
// 1997). The prey has none, and reads 0.

const PREDATOR: u32 = 0u;
const PREY: u32 = 1u;

struct SensorValues {
    view: f32, // 0.1, 0.001 to 0.5 turns: of the whole camera, 36 degrees
}

// From the left to the right.
struct SensorReadings {
    camera_0: f32,
    camera_1: f32,
    camera_2: f32,
    camera_3: f32,
    camera_4: f32,
}

fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    let prey = robot_pose(episode, PREY);
    let view = sensor_values(episode).view;
    // Turns from the heading to the prey, -0.5 to 0.5, and in sectors from the camera's left edge.
    let aside = direction(vec2<f32>(prey.x - pose.x, prey.y - pose.y)) - pose.z;
    let bearing = aside - floor(aside + 0.5f);
    let sector = 5.0f * (0.5f - bearing * reciprocal(view));
    let sees = robot_number(episode) == PREDATOR;
    return Sensed(
        SensorReadings(
            seen(sees, sector, 0.0f), seen(sees, sector, 1.0f), seen(sees, sector, 2.0f), seen(sees, sector, 3.0f),
            seen(sees, sector, 4.0f),
        ),
        before,
    );
}

fn seen(sees: bool, sector: f32, first: f32) -> f32 {
    return select(0.0f, 1.0f, sees & (sector >= first) & (sector < first + 1.0f));
}
