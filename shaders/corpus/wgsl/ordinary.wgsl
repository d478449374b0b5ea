// Ordinary WGSL: functions and operators that differ between devices, and constants without a suffix. The program that
// these kernels are compared with has the same functions in their place.

const HALF_TURN = 355.0 / 113.0;

// Not zero, since a divisor that is has no quotient to compare.
fn away(x: f32) -> f32 {
    return x + select(0.5, -0.5, x < 0.0);
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let slot = workgroup.x * 64u + lane;
    let base = slot * 16u;
    let x = floats[slot % 97u];
    let y = floats[(slot + 31u) % 97u];
    let v = vec2(x, y);
    let w = vec3(y, x + 1.0, 0.5);
    let n = i32(slot) - 50;
    let share = fract(abs(x));
    results[base] = bits(x / away(y) + 1.0 / away(x));
    results[base + 1u] = bits(sqrt(abs(x)) + length(v) - distance(w, vec3(1.0)));
    results[base + 2u] = bits(sin(x) * cos(y) + tan(share));
    results[base + 3u] = bits(atan2(y, x) + atan(x) + asin(share) - acos(-share));
    results[base + 4u] = bits(exp(share) + exp2(-share) + tanh(x));
    results[base + 5u] = bits(log(share + 0.1) + log2(abs(y) + 1.0) + pow(share + 0.1, y * 0.01));
    results[base + 6u] = bits(pow(x, 2.0) + pow(share, 3) + pow(abs(y), 0.5) + inverseSqrt(abs(x) + 1.0));
    results[base + 7u] = bits(mix(x, y, share) + smoothstep(0.2, 0.8, share) + step(x, y) + sign(x));
    results[base + 8u] = bits(ceil(x) + round(y) + degrees(share) + radians(x) + saturate(y));
    results[base + 9u] = bits(x % away(y) + HALF_TURN % away(x));
    results[base + 10u] = u32(n / (i32(lane % 7u) - 3)) ^ u32(n % (i32(lane % 5u) - 2));
    results[base + 11u] = (slot << (lane * 3u)) | u32(n >> lane);
    let turned = normalize(v) + reflect(v, vec2(0.6, 0.8)) / 3.0 + mix(v, v.yx, 0.25);
    results[base + 12u] = bits(dot(turned, v)) ^ bits(cross(w, w.zxy).y);
    results[base + 13u] = u32(any(v > vec2(0.0))) + 2u * u32(all(w > vec3(0.0))) + u32(dot(vec2(n), vec2(2, 3)));
    results[base + 14u] = bits(f32(x > y) + vec2<f32>(v > v.yx).y * fma(x, 2.0, y));
    var sum = x;
    for (var i = 0u; i < 4u; i++) {
        sum /= 1.0 + f32(i);
        if (sum > sqrt(share)) {
            sum -= 0.1 * cos(sum);
        }
    }
    results[base + 15u] = bits(sum);
}
