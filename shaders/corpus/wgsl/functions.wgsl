// Functions that few kernels need: hyperbolic ones, and those with two results.

fn split(x: f32) -> f32 {
    var parts = frexp(x);
    parts.exp += 3;
    if (parts.fract < 0.7) {
        parts = frexp(x * 3.0);
    }
    return ldexp(parts.fract, parts.exp / 2);
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let slot = workgroup.x * 64u + lane;
    let base = slot * 16u;
    let x = floats[slot % 97u];
    let y = floats[(slot + 31u) % 97u];
    let v = vec2(x, y);
    let w = vec3(y, x + 1.0, 0.5);
    let share = fract(abs(x));
    results[base] = bits(sinh(0.2 * x));
    results[base + 1u] = bits(cosh(0.2 * y) - sinh(share));
    results[base + 2u] = bits(asinh(x));
    results[base + 3u] = bits(asinh(1e10 * x) + acosh(1.0 + 1e12 * abs(y)));
    results[base + 4u] = bits(acosh(1.0 + abs(y)));
    results[base + 5u] = bits(atanh(share) - atanh(-0.5 * share));
    results[base + 6u] = bits(modf(x).fract);
    results[base + 7u] = bits(modf(v).whole.y);
    let parts = modf(w * 10.0);
    results[base + 8u] = bits((parts.fract * parts.whole.zxy).x);
    results[base + 9u] = bits(split(x + select(0.0, 1.0, x == 0.0)));
    results[base + 10u] = bits(ldexp(w, vec3<i32>(w)).y);
    results[base + 11u] = u32(frexp(vec4(w, y)).exp.w + 9);
    results[base + 12u] = bits(refract(0.01 * v, vec2(0.6, 0.8), 0.7).y);
    results[base + 13u] = bits(faceForward(w, w, w.zxy).x);
}
