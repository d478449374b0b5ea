// What a described robot's drive and battery are.

// The second cell of its numbers.
struct DriveCell {
    // greatest change of a wheel's speed in a cycle, as a share of full speed, and the inverse of that; 0 for any change
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
