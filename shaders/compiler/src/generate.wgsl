// What every generated kernel starts with: buffers of every kind, and functions that keep floats ordinary.

struct Settings {
    a: u32,
    b: u32,
    c: u32,
    d: u32,
    x: f32,
    y: f32,
    z: f32,
    w: f32,
}

struct Item {
    at: vec2<f32>,
    weight: f32,
    kind: u32,
}

struct Note {
    first: u32,
    second: f32,
    third: i32,
}

struct Local {
    f: f32,
    u: u32,
    v: vec2<f32>,
}

@group(0) @binding(0) var<uniform> settings: Settings;
@group(0) @binding(1) var<storage, read> floats: array<f32>;
@group(0) @binding(2) var<storage, read> words: array<u32>;
@group(0) @binding(3) var<storage, read> quads: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> items: array<Item>;
// Sixteen words an invocation.
@group(0) @binding(5) var<storage, read_write> results: array<u32>;
// One an invocation.
@group(0) @binding(6) var<storage, read_write> notes: array<Note>;
// Sixteen words a workgroup, each written in one place of the text with what is uniform there.
@group(0) @binding(7) var<storage, read_write> shared_words: array<u32>;

var<private> total: f32 = 1.5f;
var<private> count: u32;

// Zero, or between 2^-20 and 256 in size: products of two such numbers are neither subnormal nor large.
fn tame(x: f32) -> f32 {
    let y = clamp(x, -256.0f, 256.0f);
    return select(y, 0.0f, abs(y) < 0x1p-20f);
}

fn tame2(v: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(tame(v.x), tame(v.y));
}

fn stored(x: f32) -> f32 {
    return select(x, 0.0f, x == 0.0f);
}

fn bits(x: f32) -> u32 {
    return bitcast<u32>(stored(x));
}

fn whole(x: f32) -> u32 {
    return u32(clamp(x, 0.0f, 4096.0f));
}

fn whole_signed(x: f32) -> i32 {
    return i32(clamp(x, -4096.0f, 4096.0f));
}

