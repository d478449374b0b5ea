// One operation of the closed list of allowed ones at a time, for tests and for `oneiro device test`: the same
// operands must give the same bits on every device, with both operands known at run time only, and with one of
// them a constant, since compilers fold those. src/devices/probe/operations.rs makes the operands.

// The type of the operands.
const F32: u32 = 0u;
const I32: u32 = 1u;
const U32: u32 = 2u;
const BOOL: u32 = 3u;

// Operations on two operands.
const ADD: u32 = 0u;
const SUBTRACT: u32 = 1u;
const MULTIPLY: u32 = 2u;
const MINIMUM: u32 = 3u;
const MAXIMUM: u32 = 4u;
const IS_LESS: u32 = 5u;
const IS_LESS_OR_EQUAL: u32 = 6u;
const IS_GREATER: u32 = 7u;
const IS_GREATER_OR_EQUAL: u32 = 8u;
const IS_EQUAL: u32 = 9u;
const IS_UNEQUAL: u32 = 10u;
const SELECT: u32 = 11u;
const MULTIPLY_ADD: u32 = 12u;
const SUBTRACT_PRODUCT: u32 = 13u;
const SUBTRACT_SQUARES: u32 = 14u;
const ADD_SUBTRACT: u32 = 15u;
const SUBTRACT_ADD: u32 = 16u;
const CLAMP: u32 = 17u;
const AND: u32 = 18u;
const OR: u32 = 19u;
const XOR: u32 = 20u;
const SHIFT_LEFT: u32 = 21u;
const SHIFT_RIGHT: u32 = 22u;
const DIVIDE: u32 = 23u;
const REMAINDER: u32 = 24u;
const BOTH: u32 = 25u;
const EITHER: u32 = 26u;

// Operations on one, which are numbered from here on.
const ALONE: u32 = 27u;
const NEGATE: u32 = 27u;
const ABSOLUTE: u32 = 28u;
const FLOOR: u32 = 29u;
const TRUNCATE: u32 = 30u;
const TO_I32: u32 = 31u;
const TO_U32: u32 = 32u;
const SAME: u32 = 33u;
const COMPLEMENT: u32 = 34u;
const TO_F32: u32 = 35u;
const CLAMP_ALONE: u32 = 36u;
const NOT: u32 = 37u;

// Which operand is a constant: none, or the right or the left one, which is 0, 1, -1 or 2.
const OPEN: u32 = 0u;
const RIGHT_0: u32 = 1u;
const RIGHT_1: u32 = 2u;
const RIGHT_MINUS_1: u32 = 3u;
const RIGHT_2: u32 = 4u;
const LEFT_0: u32 = 5u;
const LEFT_1: u32 = 6u;
const LEFT_MINUS_1: u32 = 7u;
const LEFT_2: u32 = 8u;

// What one dispatch does.
struct Probe {
    scalar: u32,
    operation: u32,
    form: u32,
    // pairs of operands
    count: u32,
}

fn truth(condition: bool) -> u32 {
    return select(0u, 1u, condition);
}

// From MULTIPLY_ADD on, what compilers would like to contract, to reassociate or to fold.
fn f32_pair(x: f32, y: f32) -> u32 {
    var value = 0u;
    switch (probe.operation) {
        case ADD: { value = stored_bits(x + y); }
        case SUBTRACT: { value = stored_bits(x - y); }
        case MULTIPLY: { value = stored_bits(x * y); }
        case MINIMUM: { value = stored_bits(min(x, y)); }
        case MAXIMUM: { value = stored_bits(max(x, y)); }
        case IS_LESS: { value = truth(x < y); }
        case IS_LESS_OR_EQUAL: { value = truth(x <= y); }
        case IS_GREATER: { value = truth(x > y); }
        case IS_GREATER_OR_EQUAL: { value = truth(x >= y); }
        case IS_EQUAL: { value = truth(x == y); }
        case IS_UNEQUAL: { value = truth(x != y); }
        case SELECT: { value = stored_bits(select(x, y, x > y)); }
        case MULTIPLY_ADD: { value = stored_bits(x * y + x); }
        case SUBTRACT_PRODUCT: { value = stored_bits(y - x * y); }
        case SUBTRACT_SQUARES: { value = stored_bits(x * x - y * y); }
        case ADD_SUBTRACT: { value = stored_bits((x + y) - y); }
        case SUBTRACT_ADD: { value = stored_bits((x - y) + y); }
        case CLAMP: { value = stored_bits(clamp(x, -abs(y), abs(y))); }
        default: {}
    }
    return value;
}

fn f32_alone(x: f32) -> u32 {
    var value = 0u;
    switch (probe.operation) {
        case NEGATE: { value = stored_bits(-x); }
        case ABSOLUTE: { value = stored_bits(abs(x)); }
        case FLOOR: { value = stored_bits(floor(x)); }
        case TRUNCATE: { value = stored_bits(trunc(x)); }
        case TO_I32: { value = bitcast<u32>(i32(clamp(x, -16777215.0f, 16777215.0f))); }
        case TO_U32: { value = u32(clamp(x, 0.0f, 16777215.0f)); }
        case SAME: { value = stored_bits(x); }
        default: {}
    }
    return value;
}

// Shift counts are brought into range, and below the operands of division, which is for u32 only.
fn i32_pair(x: i32, y: i32) -> u32 {
    var value = 0i;
    switch (probe.operation) {
        case ADD: { value = x + y; }
        case SUBTRACT: { value = x - y; }
        case MULTIPLY: { value = x * y; }
        case MINIMUM: { value = min(x, y); }
        case MAXIMUM: { value = max(x, y); }
        case IS_LESS: { value = i32(truth(x < y)); }
        case IS_LESS_OR_EQUAL: { value = i32(truth(x <= y)); }
        case IS_GREATER: { value = i32(truth(x > y)); }
        case IS_GREATER_OR_EQUAL: { value = i32(truth(x >= y)); }
        case IS_EQUAL: { value = i32(truth(x == y)); }
        case IS_UNEQUAL: { value = i32(truth(x != y)); }
        case SELECT: { value = select(x, y, x > y); }
        case AND: { value = x & y; }
        case OR: { value = x | y; }
        case XOR: { value = x ^ y; }
        case SHIFT_LEFT: { value = x << (u32(y) & 31u); }
        case SHIFT_RIGHT: { value = x >> (u32(y) & 31u); }
        default: {}
    }
    return bitcast<u32>(value);
}

fn i32_alone(x: i32) -> u32 {
    var value = 0u;
    switch (probe.operation) {
        case NEGATE: { value = bitcast<u32>(-x); }
        case COMPLEMENT: { value = bitcast<u32>(~x); }
        case TO_F32: { value = stored_bits(f32(x >> 8u)); }
        case TO_U32: { value = u32(x); }
        case CLAMP_ALONE: { value = bitcast<u32>(clamp(x, -1000i, 1000i)); }
        default: {}
    }
    return value;
}

fn u32_pair(x: u32, y: u32) -> u32 {
    var value = 0u;
    switch (probe.operation) {
        case ADD: { value = x + y; }
        case SUBTRACT: { value = x - y; }
        case MULTIPLY: { value = x * y; }
        case MINIMUM: { value = min(x, y); }
        case MAXIMUM: { value = max(x, y); }
        case IS_LESS: { value = truth(x < y); }
        case IS_LESS_OR_EQUAL: { value = truth(x <= y); }
        case IS_GREATER: { value = truth(x > y); }
        case IS_GREATER_OR_EQUAL: { value = truth(x >= y); }
        case IS_EQUAL: { value = truth(x == y); }
        case IS_UNEQUAL: { value = truth(x != y); }
        case SELECT: { value = select(x, y, x > y); }
        case AND: { value = x & y; }
        case OR: { value = x | y; }
        case XOR: { value = x ^ y; }
        case SHIFT_LEFT: { value = x << (y & 31u); }
        case SHIFT_RIGHT: { value = x >> (y & 31u); }
        case DIVIDE: { value = (x & 0x7fffffffu) / ((y & 0x7fffffffu) | 1u); }
        case REMAINDER: { value = (x & 0x7fffffffu) % ((y & 0x7fffffffu) | 1u); }
        default: {}
    }
    return value;
}

fn u32_alone(x: u32) -> u32 {
    var value = 0u;
    switch (probe.operation) {
        case COMPLEMENT: { value = ~x; }
        case TO_F32: { value = stored_bits(f32(x >> 8u)); }
        case TO_I32: { value = bitcast<u32>(i32(x)); }
        case CLAMP_ALONE: { value = clamp(x, 1000u, 2000000000u); }
        default: {}
    }
    return value;
}

fn bool_pair(x: bool, y: bool) -> u32 {
    var value = false;
    switch (probe.operation) {
        case BOTH: { value = x && y; }
        case EITHER: { value = x || y; }
        case AND: { value = x & y; }
        case OR: { value = x | y; }
        case NOT: { value = !x; }
        case SELECT: { value = select(x, y, !x); }
        default: {}
    }
    return truth(value);
}

fn f32_value(x: f32, y: f32) -> u32 {
    if (probe.operation >= ALONE) {
        return f32_alone(x);
    }
    var value = 0u;
    switch (probe.form) {
        case OPEN: { value = f32_pair(x, y); }
        case RIGHT_0: { value = f32_pair(x, 0.0f); }
        case RIGHT_1: { value = f32_pair(x, 1.0f); }
        case RIGHT_MINUS_1: { value = f32_pair(x, -1.0f); }
        case RIGHT_2: { value = f32_pair(x, 2.0f); }
        case LEFT_0: { value = f32_pair(0.0f, y); }
        case LEFT_1: { value = f32_pair(1.0f, y); }
        case LEFT_MINUS_1: { value = f32_pair(-1.0f, y); }
        case LEFT_2: { value = f32_pair(2.0f, y); }
        default: {}
    }
    return value;
}

fn i32_value(x: i32, y: i32) -> u32 {
    if (probe.operation >= ALONE) {
        return i32_alone(x);
    }
    var value = 0u;
    switch (probe.form) {
        case OPEN: { value = i32_pair(x, y); }
        case RIGHT_0: { value = i32_pair(x, 0i); }
        case RIGHT_1: { value = i32_pair(x, 1i); }
        case RIGHT_MINUS_1: { value = i32_pair(x, -1i); }
        case RIGHT_2: { value = i32_pair(x, 2i); }
        case LEFT_0: { value = i32_pair(0i, y); }
        case LEFT_1: { value = i32_pair(1i, y); }
        case LEFT_MINUS_1: { value = i32_pair(-1i, y); }
        case LEFT_2: { value = i32_pair(2i, y); }
        default: {}
    }
    return value;
}

fn u32_value(x: u32, y: u32) -> u32 {
    if (probe.operation >= ALONE) {
        return u32_alone(x);
    }
    var value = 0u;
    switch (probe.form) {
        case OPEN: { value = u32_pair(x, y); }
        case RIGHT_0: { value = u32_pair(x, 0u); }
        case RIGHT_1: { value = u32_pair(x, 1u); }
        case RIGHT_MINUS_1: { value = u32_pair(x, 0xffffffffu); }
        case RIGHT_2: { value = u32_pair(x, 2u); }
        case LEFT_0: { value = u32_pair(0u, y); }
        case LEFT_1: { value = u32_pair(1u, y); }
        case LEFT_MINUS_1: { value = u32_pair(0xffffffffu, y); }
        case LEFT_2: { value = u32_pair(2u, y); }
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
    switch (probe.scalar) {
        case F32: { value = f32_value(bitcast<f32>(x), bitcast<f32>(y)); }
        case I32: { value = i32_value(bitcast<i32>(x), bitcast<i32>(y)); }
        case U32: { value = u32_value(x, y); }
        case BOOL: { value = bool_pair((x & 1u) != 0u, (y & 1u) != 0u); }
        default: {}
    }
    results[i] = value;
}
