// Random numbers by counter: a word is a function of who asks and when, never of what was asked before, so
// that order, chunks, batches and threads cannot matter. The hash is pcg4d (Jarzynski and Olano, "Hash
// Functions for GPU Rendering", JCGT 9(3), 2020) with a third round: 128 bits in, 128 bits out, a bijection.
// With the two rounds of the paper consecutive steps fail statistical tests at once (docs/numerics.md).

const STREAM_START: u32 = 0u;
const STREAM_SENSOR: u32 = 1u;
const STREAM_ACTUATOR: u32 = 2u;
const STREAM_ENVIRONMENT: u32 = 3u;
const STREAM_BEHAVIOUR: u32 = 4u;
// For parts that a user wrote.
const STREAM_TASK: u32 = 5u;
const STREAM_CONTROLLER: u32 = 6u;
const STREAM_OWN_SENSOR: u32 = 7u;

// Four random words: the block-th four of a stream at a step (of the episode, not of the chunk; block < 2^16).
fn random_words(key: vec2<u32>, stream: u32, step: u32, block: u32) -> vec4<u32> {
    var v = vec4<u32>(key.x, key.y, step, (stream << 16u) | block);
    v = random_round(v * 1664525u + 1013904223u);
    v = random_round(v ^ (v >> vec4<u32>(16u)));
    return random_round(v ^ (v >> vec4<u32>(16u)));
}

// Each word takes in the product of two others.
fn random_round(words: vec4<u32>) -> vec4<u32> {
    var v = words;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

// A word as a number in [0, 1), a multiple of 2^-24.
fn unit(word: u32) -> f32 {
    return f32(word >> 8u) * 0x1p-24f;
}

// Four words as numbers in [0, 1).
fn units(words: vec4<u32>) -> vec4<f32> {
    return vec4<f32>(unit(words.x), unit(words.y), unit(words.z), unit(words.w));
}

// A number that is nearly normal, of mean 0 and standard deviation 1: three uniform ones of ten bits each.
fn nearly_normal(word: u32) -> f32 {
    let sum = (word & 1023u) + ((word >> 10u) & 1023u) + ((word >> 20u) & 1023u);
    return (f32(sum) - 1534.5f) * 0x1p-9f;
}
