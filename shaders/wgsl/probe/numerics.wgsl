// One function of lib/numerics.wgsl or lib/random.wgsl at a time, for tests and for `oneiro selftest`: the
// same arguments must give the same bits on every device. src/probe.rs names the functions and makes the arguments.

// What one dispatch does.
struct Probe {
    // which function, by its number below
    function: u32,
    // arguments
    count: u32,
    // the step and block of the random words
    step: u32,
    block: u32,
}

// Not a uniform: lavapipe would compile the kernel anew for each of its values.
@group(0) @binding(0) var<storage, read> probe: Probe;
// First and second arguments; f32 as its bits.
@group(0) @binding(1) var<storage, read> left: array<u32>;
@group(0) @binding(2) var<storage, read> right: array<u32>;
@group(0) @binding(3) var<storage, read_write> results: array<u32>;

// A number's bits, with zero's one sign.
fn stored_bits(x: f32) -> u32 {
    return bitcast<u32>(select(x, 0.0f, x == 0.0f));
}

fn number_value(x: f32, y: f32) -> f32 {
    var value = 0.0f;
    switch (probe.function) {
        case 0u: { value = reciprocal(x); }
        case 1u: { value = reciprocal_root(x); }
        case 2u: { value = root(x); }
        case 3u: { value = cosine_sine(x).x; }
        case 4u: { value = cosine_sine(x).y; }
        case 5u: { value = direction(vec2<f32>(x, y)); }
        case 6u: { value = exponential(x); }
        case 7u: { value = logistic(x); }
        case 8u: { value = logarithm(x); }
        default: {}
    }
    return value;
}

fn word_value(key: vec2<u32>) -> u32 {
    let words = random_words(key, STREAM_SENSOR, probe.step, probe.block);
    var value = 0u;
    switch (probe.function) {
        case 9u: { value = stored_bits(unit(key.x)); }
        case 10u: { value = words.x; }
        case 11u: { value = words.y; }
        case 12u: { value = words.z; }
        case 13u: { value = words.w; }
        default: {}
    }
    return value;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = workgroup.x * 64u + lane;
    if (i >= probe.count) {
        return;
    }
    if (probe.function < 9u) {
        results[i] = stored_bits(number_value(bitcast<f32>(left[i]), bitcast<f32>(right[i])));
    } else {
        results[i] = word_value(vec2<u32>(left[i], right[i]));
    }
}
