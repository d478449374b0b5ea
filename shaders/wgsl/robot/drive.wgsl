// A parametric robot's drive and battery.

// The second cell of its numbers.
struct DriveCell {
    // maximum change of a wheel's speed in a cycle, as a fraction of full speed, and the inverse of that; 0 for any change
    change: f32,
    changes: f32,
    // cycles that a full battery lasts, and the inverse of that; 0 without a battery
    cycles: f32,
    cycle: f32,
}

fn drive_of(world: u32) -> DriveCell {
    let cell = numbers(world, 1u);
    return DriveCell(cell.x, cell.y, cell.z, cell.w);
}

// Two independent normal numbers of mean 0 and standard deviation 1 (Box and Muller, 1958), of 24 bits each: at most 5.77.
fn normal_pair(words: vec4<u32>) -> vec2<f32> {
    // From 2^-24 to 1.
    let share = f32((words.x >> 8u) + 1u) * 0x1p-24f;
    return root(-2.0f * logarithm(share)) * cosine_sine(unit(words.y));
}

// Two speeds of a wheel, as fractions of full speed: at the end of a cycle, and the mean over it.
struct WheelSpeed {
    end: f32,
    mean: f32,
}

// The speed of a wheel that is commanded to get from one speed to another: it changes evenly until it is there, or throughout
// the cycle. Speeds within 1e-9 of each other count as equal.
fn accelerated(drive: DriveCell, speed: f32, goal: f32) -> WheelSpeed {
    let wanted = goal - speed;
    let change = select(clamp(wanted, -drive.change, drive.change), 0.0f, abs(wanted) < 0x1p-30f);
    let end = select(speed + change, goal, abs(wanted) <= drive.change);
    // While it changes, which is this share of the cycle, it lags by half of the change in the mean.
    let share = min(abs(change) * drive.changes, 1.0f);
    return WheelSpeed(end, end - 0.5f * change * share);
}
