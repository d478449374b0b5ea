// The floor that custom parts of a single robot ask for, where it has a picture. It replaces the function of lib/given.wgsl.

// The grey of the floor at a place, from 0 for black to 1 for white: that of the last patch there, or else of the picture.
fn floor_at(episode: Episode, place: vec2<f32>) -> f32 {
    let floor = given_numbers(episode, 0u);
    let head = worlds[episode.world].own_values + GIVEN_CELL + u32(floor.z);
    return given_grey(episode, place, picture_grey(head, place, floor.y));
}
