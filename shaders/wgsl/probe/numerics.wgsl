// One function of lib/numerics.wgsl or lib/random.wgsl at a time, for tests and for `oneiro selftest`: the
// same arguments must give the same bits on every device. src/probe.rs names the functions and makes the arguments.

// What one dispatch does.
struct Probe {
    // which function, by its number in `function_value`
    function: u32,
    // arguments
    count: u32,
    // the step and block of the random words
    step: u32,
    block: u32,
}

@group(0) @binding(0) var<uniform> probe: Probe;
// First and second arguments; f32 as its bits.
@group(0) @binding(1) var<storage, read> left: array<u32>;
@group(0) @binding(2) var<storage, read> right: array<u32>;
@group(0) @binding(3) var<storage, read_write> results: array<u32>;

// A number's bits, with zero's one sign.
fn stored_bits(x: f32) -> u32 {
    return bitcast<u32>(select(x, 0.0f, x == 0.0f));
}

fn function_value(a: u32, b: u32) -> u32 {
    let x = bitcast<f32>(a);
    let y = bitcast<f32>(b);
    var value = 0u;
    switch (probe.function) {
        case 0u: { value = stored_bits(reciprocal(x)); }
        case 1u: { value = stored_bits(reciprocal_root(x)); }
        case 2u: { value = stored_bits(root(x)); }
        case 3u: { value = stored_bits(cosine_sine(x).x); }
        case 4u: { value = stored_bits(cosine_sine(x).y); }
        case 5u: { value = stored_bits(direction(vec2<f32>(x, y))); }
        case 6u: { value = stored_bits(exponential(x)); }
        case 7u: { value = stored_bits(logistic(x)); }
        case 8u: { value = stored_bits(logarithm(x)); }
        case 9u: { value = stored_bits(unit(a)); }
        case 10u: { value = random_words(vec2<u32>(a, b), STREAM_SENSOR, probe.step, probe.block).x; }
        case 11u: { value = random_words(vec2<u32>(a, b), STREAM_SENSOR, probe.step, probe.block).y; }
        case 12u: { value = random_words(vec2<u32>(a, b), STREAM_SENSOR, probe.step, probe.block).z; }
        case 13u: { value = random_words(vec2<u32>(a, b), STREAM_SENSOR, probe.step, probe.block).w; }
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
    results[i] = function_value(left[i], right[i]);
}
