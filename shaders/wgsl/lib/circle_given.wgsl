// Functions for users' parts in an arena whose wall is a circle around the origin; they replace those of `given.wgsl`.

// The gap between a robot's body and the wall if its centre is at a place; negative where they overlap, and at most `most`.
fn clearance(episode: Episode, at: vec2<f32>, most: f32) -> f32 {
    let room = arena_of(episode.world).radius - robot_of(episode.world).radius;
    return min(room - root(squared_length(at)), most);
}
