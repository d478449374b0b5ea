// One function of lib/numerics.wgsl or lib/random.wgsl at a time, for tests and for `oneiro device test`: the
// same arguments must give the same bits on every device. src/devices/probe/functions.rs makes the arguments.

// Functions of numbers.
const RECIPROCAL: u32 = 0u;
const RECIPROCAL_ROOT: u32 = 1u;
const ROOT: u32 = 2u;
const COSINE: u32 = 3u;
const SINE: u32 = 4u;
const DIRECTION: u32 = 5u;
const EXPONENTIAL: u32 = 6u;
const LOGISTIC: u32 = 7u;
const LOGARITHM: u32 = 8u;

// Functions of words, which are numbered from here on.
const WORDS: u32 = 9u;
const UNIT: u32 = 9u;
const WORD_0: u32 = 10u;
const WORD_1: u32 = 11u;
const WORD_2: u32 = 12u;
const WORD_3: u32 = 13u;

// What one dispatch does.
struct Probe {
    function: u32,
    // arguments
    count: u32,
    // the step and block of the random words
    step: u32,
    block: u32,
}

fn number_value(x: f32, y: f32) -> f32 {
    var value = 0.0f;
    switch (probe.function) {
        case RECIPROCAL: { value = reciprocal(x); }
        case RECIPROCAL_ROOT: { value = reciprocal_root(x); }
        case ROOT: { value = root(x); }
        case COSINE: { value = cosine_sine(x).x; }
        case SINE: { value = cosine_sine(x).y; }
        case DIRECTION: { value = direction(vec2<f32>(x, y)); }
        case EXPONENTIAL: { value = exponential(x); }
        case LOGISTIC: { value = logistic(x); }
        case LOGARITHM: { value = logarithm(x); }
        default: {}
    }
    return value;
}

fn word_value(key: vec2<u32>) -> u32 {
    let words = random_words(key, STREAM_SENSOR, probe.step, probe.block);
    var value = 0u;
    switch (probe.function) {
        case UNIT: { value = stored_bits(unit(key.x)); }
        case WORD_0: { value = words.x; }
        case WORD_1: { value = words.y; }
        case WORD_2: { value = words.z; }
        case WORD_3: { value = words.w; }
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
    if (probe.function < WORDS) {
        results[i] = stored_bits(number_value(bitcast<f32>(left[i]), bitcast<f32>(right[i])));
    } else {
        results[i] = word_value(vec2<u32>(left[i], right[i]));
    }
}
