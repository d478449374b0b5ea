// One operation of the closed list of allowed ones at a time, for tests and for `oneiro selftest`: the same
// operands must give the same bits on every device, with both operands known at run time only, and with one of
// them a constant, since compilers fold those. src/probe.rs names the operations and makes the operands.

// What one dispatch does.
struct Probe {
    // type (0 f32, 1 i32, 2 u32, 3 bool) times 256, plus the number in the type's function below
    operation: u32,
    // which operand is a constant: 0 none; 1 to 4 the right one, which is 0, 1, -1 or 2; 5 to 8 the left one
    form: u32,
    // pairs of operands
    count: u32,
    unused: u32,
}

// Not a uniform: lavapipe would compile the kernel anew for each of its values.
@group(0) @binding(0) var<storage, read> probe: Probe;
// Left and right operands; f32 and i32 as their bits.
@group(0) @binding(1) var<storage, read> left: array<u32>;
@group(0) @binding(2) var<storage, read> right: array<u32>;
@group(0) @binding(3) var<storage, read_write> results: array<u32>;

// A number's bits, with zero's one sign.
fn stored_bits(x: f32) -> u32 {
    return bitcast<u32>(select(x, 0.0f, x == 0.0f));
}

fn truth(condition: bool) -> u32 {
    return select(0u, 1u, condition);
}

// From 12 on, what compilers would like to contract, to reassociate or to fold.
fn f32_pair(x: f32, y: f32) -> u32 {
    var value = 0u;
    switch (probe.operation & 255u) {
        case 0u: { value = stored_bits(x + y); }
        case 1u: { value = stored_bits(x - y); }
        case 2u: { value = stored_bits(x * y); }
        case 3u: { value = stored_bits(min(x, y)); }
        case 4u: { value = stored_bits(max(x, y)); }
        case 5u: { value = truth(x < y); }
        case 6u: { value = truth(x <= y); }
        case 7u: { value = truth(x > y); }
        case 8u: { value = truth(x >= y); }
        case 9u: { value = truth(x == y); }
        case 10u: { value = truth(x != y); }
        case 11u: { value = stored_bits(select(x, y, x > y)); }
        case 12u: { value = stored_bits(x * y + x); }
        case 13u: { value = stored_bits(y - x * y); }
        case 14u: { value = stored_bits(x * x - y * y); }
        case 15u: { value = stored_bits((x + y) - y); }
        case 16u: { value = stored_bits((x - y) + y); }
        case 17u: { value = stored_bits(clamp(x, -abs(y), abs(y))); }
        default: {}
    }
    return value;
}

fn f32_alone(x: f32) -> u32 {
    var value = 0u;
    switch (probe.operation & 255u) {
        case 32u: { value = stored_bits(-x); }
        case 33u: { value = stored_bits(abs(x)); }
        case 34u: { value = stored_bits(floor(x)); }
        case 35u: { value = stored_bits(trunc(x)); }
        case 36u: { value = bitcast<u32>(i32(clamp(x, -16777215.0f, 16777215.0f))); }
        case 37u: { value = u32(clamp(x, 0.0f, 16777215.0f)); }
        case 38u: { value = stored_bits(x); }
        default: {}
    }
    return value;
}

// Shift counts are brought into range, and below the operands of division, which is for u32 only.
fn i32_pair(x: i32, y: i32) -> u32 {
    var value = 0i;
    switch (probe.operation & 255u) {
        case 0u: { value = x + y; }
        case 1u: { value = x - y; }
        case 2u: { value = x * y; }
        case 3u: { value = min(x, y); }
        case 4u: { value = max(x, y); }
        case 5u: { value = i32(truth(x < y)); }
        case 6u: { value = i32(truth(x <= y)); }
        case 7u: { value = i32(truth(x > y)); }
        case 8u: { value = i32(truth(x >= y)); }
        case 9u: { value = i32(truth(x == y)); }
        case 10u: { value = i32(truth(x != y)); }
        case 11u: { value = select(x, y, x > y); }
        case 12u: { value = x & y; }
        case 13u: { value = x | y; }
        case 14u: { value = x ^ y; }
        case 15u: { value = x << (u32(y) & 31u); }
        case 16u: { value = x >> (u32(y) & 31u); }
        default: {}
    }
    return bitcast<u32>(value);
}

fn i32_alone(x: i32) -> u32 {
    var value = 0u;
    switch (probe.operation & 255u) {
        case 32u: { value = bitcast<u32>(-x); }
        case 33u: { value = bitcast<u32>(~x); }
        case 34u: { value = stored_bits(f32(x >> 8u)); }
        case 35u: { value = u32(x); }
        case 36u: { value = bitcast<u32>(clamp(x, -1000i, 1000i)); }
        default: {}
    }
    return value;
}

fn u32_pair(x: u32, y: u32) -> u32 {
    var value = 0u;
    switch (probe.operation & 255u) {
        case 0u: { value = x + y; }
        case 1u: { value = x - y; }
        case 2u: { value = x * y; }
        case 3u: { value = min(x, y); }
        case 4u: { value = max(x, y); }
        case 5u: { value = truth(x < y); }
        case 6u: { value = truth(x <= y); }
        case 7u: { value = truth(x > y); }
        case 8u: { value = truth(x >= y); }
        case 9u: { value = truth(x == y); }
        case 10u: { value = truth(x != y); }
        case 11u: { value = select(x, y, x > y); }
        case 12u: { value = x & y; }
        case 13u: { value = x | y; }
        case 14u: { value = x ^ y; }
        case 15u: { value = x << (y & 31u); }
        case 16u: { value = x >> (y & 31u); }
        case 17u: { value = (x & 0x7fffffffu) / ((y & 0x7fffffffu) | 1u); }
        case 18u: { value = (x & 0x7fffffffu) % ((y & 0x7fffffffu) | 1u); }
        default: {}
    }
    return value;
}

fn u32_alone(x: u32) -> u32 {
    var value = 0u;
    switch (probe.operation & 255u) {
        case 32u: { value = ~x; }
        case 33u: { value = stored_bits(f32(x >> 8u)); }
        case 34u: { value = bitcast<u32>(i32(x)); }
        case 35u: { value = clamp(x, 1000u, 2000000000u); }
        default: {}
    }
    return value;
}

fn bool_pair(x: bool, y: bool) -> u32 {
    var value = false;
    switch (probe.operation & 255u) {
        case 0u: { value = x && y; }
        case 1u: { value = x || y; }
        case 2u: { value = x & y; }
        case 3u: { value = x | y; }
        case 4u: { value = !x; }
        case 5u: { value = select(x, y, !x); }
        default: {}
    }
    return truth(value);
}

fn f32_value(x: f32, y: f32) -> u32 {
    if ((probe.operation & 255u) >= 32u) {
        return f32_alone(x);
    }
    var value = 0u;
    switch (probe.form) {
        case 0u: { value = f32_pair(x, y); }
        case 1u: { value = f32_pair(x, 0.0f); }
        case 2u: { value = f32_pair(x, 1.0f); }
        case 3u: { value = f32_pair(x, -1.0f); }
        case 4u: { value = f32_pair(x, 2.0f); }
        case 5u: { value = f32_pair(0.0f, y); }
        case 6u: { value = f32_pair(1.0f, y); }
        case 7u: { value = f32_pair(-1.0f, y); }
        case 8u: { value = f32_pair(2.0f, y); }
        default: {}
    }
    return value;
}

fn i32_value(x: i32, y: i32) -> u32 {
    if ((probe.operation & 255u) >= 32u) {
        return i32_alone(x);
    }
    var value = 0u;
    switch (probe.form) {
        case 0u: { value = i32_pair(x, y); }
        case 1u: { value = i32_pair(x, 0i); }
        case 2u: { value = i32_pair(x, 1i); }
        case 3u: { value = i32_pair(x, -1i); }
        case 4u: { value = i32_pair(x, 2i); }
        case 5u: { value = i32_pair(0i, y); }
        case 6u: { value = i32_pair(1i, y); }
        case 7u: { value = i32_pair(-1i, y); }
        case 8u: { value = i32_pair(2i, y); }
        default: {}
    }
    return value;
}

fn u32_value(x: u32, y: u32) -> u32 {
    if ((probe.operation & 255u) >= 32u) {
        return u32_alone(x);
    }
    var value = 0u;
    switch (probe.form) {
        case 0u: { value = u32_pair(x, y); }
        case 1u: { value = u32_pair(x, 0u); }
        case 2u: { value = u32_pair(x, 1u); }
        case 3u: { value = u32_pair(x, 0xffffffffu); }
        case 4u: { value = u32_pair(x, 2u); }
        case 5u: { value = u32_pair(0u, y); }
        case 6u: { value = u32_pair(1u, y); }
        case 7u: { value = u32_pair(0xffffffffu, y); }
        case 8u: { value = u32_pair(2u, y); }
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
    let x = left[i];
    let y = right[i];
    var value = 0u;
    switch (probe.operation >> 8u) {
        case 0u: { value = f32_value(bitcast<f32>(x), bitcast<f32>(y)); }
        case 1u: { value = i32_value(bitcast<i32>(x), bitcast<i32>(y)); }
        case 2u: { value = u32_value(x, y); }
        case 3u: { value = bool_pair((x & 1u) != 0u, (y & 1u) != 0u); }
        default: {}
    }
    results[i] = value;
}
