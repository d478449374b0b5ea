// What a parametric robot's sensors read of a floor with a picture. It replaces the function of sensor/kinds.wgsl.

// The grey of the floor below the sensor. PICTURE_CELL is generated: where the picture's head is.
fn ground_reading(world: u32, place: vec2<f32>) -> f32 {
    let beneath = picture_grey(worlds[world].numbers + PICTURE_CELL, place, numbers(world, FLOOR_CELL).x);
    return patches_grey(world, place, beneath);
}
