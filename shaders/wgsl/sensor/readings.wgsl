// Eight readings, and what controllers and tasks take from them.

// One value a sensor, in [0, 1].
struct Readings {
    first: vec4<f32>,
    last: vec4<f32>,
}

// A sum of readings as an activation, clipped to 1.
fn activation(sum: u32, scale: f32) -> f32 {
    return min(f32(sum) * scale, 1.0f);
}

// The greatest of eight readings.
fn highest(r: Readings) -> f32 {
    let a = max(max(r.first.x, r.first.y), max(r.first.z, r.first.w));
    let b = max(max(r.last.x, r.last.y), max(r.last.z, r.last.w));
    return max(a, b);
}

// The sum of eight readings, each times its gene; gene `index` weighs the first.
fn weighed(life: Life, index: u32, r: Readings) -> f32 {
    var sum = gene(life, index) * r.first.x;
    sum += gene(life, index + 1u) * r.first.y;
    sum += gene(life, index + 2u) * r.first.z;
    sum += gene(life, index + 3u) * r.first.w;
    sum += gene(life, index + 4u) * r.last.x;
    sum += gene(life, index + 5u) * r.last.y;
    sum += gene(life, index + 6u) * r.last.z;
    sum += gene(life, index + 7u) * r.last.w;
    return sum;
}
