// An arena without objects whose wall is a circle around the origin.

// Whether a robot's body that stands there touches the wall.
fn touches(world: u32, at: vec2<f32>) -> bool {
    let room = arena_of(world).radius - robot_of(world).radius;
    return squared_length(at) > room * room;
}
