// An e-puck as its on-board simulator has it: alone, and like any other.

// What the four sensors at the front read of the wall, in [0, 1].
fn near(episode: Episode, step: u32, pose: vec3<f32>) -> vec4<f32> {
    return near_readings(episode, step, wall_distances(episode.world, pose));
}

// What four sensors read of the light, in [0, 1].
fn light(episode: Episode, step: u32, half: u32, pose: vec3<f32>) -> vec4<f32> {
    let lamp = lamp_of(episode.world);
    var shine = vec4<f32>(0.0f);
    if (lamp.shines > 0.0f) {
        shine = lamp_light(episode.world, half, pose, vec2<f32>(lamp.x, lamp.y));
    }
    return light_readings(episode, step, half, shine);
}

// What each wheel makes of a command.
fn wheels(episode: Episode) -> vec2<f32> {
    return vec2<f32>(1.0f, 1.0f);
}
