// Conservative noise: a random walk displaces what is perceived.

// One step of the walk that displaces what is perceived, reflected at its range.
fn walked(episode: Episode, step: u32, shift: vec2<f32>) -> vec2<f32> {
    let u = units(random_words(episode.key, STREAM_ENVIRONMENT, step, 0u));
    let size = worlds[episode.world].walk_step;
    let range = worlds[episode.world].walk_range;
    return vec2<f32>(
        reflected(shift.x + (2.0f * u.x - 1.0f) * size, range),
        reflected(shift.y + (2.0f * u.y - 1.0f) * size, range),
    );
}

// Where the walk starts: uniform within its range.
fn first_shift(episode: Episode) -> vec2<f32> {
    let u = units(random_words(episode.key, STREAM_ENVIRONMENT, 0u, 1u));
    let range = worlds[episode.world].walk_range;
    return vec2<f32>((2.0f * u.x - 1.0f) * range, (2.0f * u.y - 1.0f) * range);
}

// A number folded back once at -range and range.
fn reflected(x: f32, range: f32) -> f32 {
    let below = select(x, -2.0f * range - x, x < -range);
    return select(below, 2.0f * range - below, below > range);
}
