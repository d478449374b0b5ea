// Functions that kernels need and WGSL's own give no exact promise for, written from exactly rounded
// operations only: an integer first guess and Newton steps, or a polynomial in Horner form. The greatest
// errors below are measured by `cargo test -p oneiro --test numerics` over every float of the range, or
// over the grid that it names.

// 1/x for x in [2^-100, 2^100].
fn reciprocal(x: f32) -> f32 {
    var y = bitcast<f32>(0x7ef311c3u - bitcast<u32>(x));
    y = y * (2.0f - x * y);
    y = y * (2.0f - x * y);
    y = y * (2.0f - x * y);
    return y;
}

// 1/sqrt(x) for x in [2^-100, 2^100].
fn reciprocal_root(x: f32) -> f32 {
    let half = 0.5f * x;
    var y = bitcast<f32>(0x5f3759dfu - (bitcast<u32>(x) >> 1u));
    y = y * (1.5f - half * y * y);
    y = y * (1.5f - half * y * y);
    y = y * (1.5f - half * y * y);
    return y;
}

// sqrt(x) for x = 0 or in [2^-100, 2^100].
fn root(x: f32) -> f32 {
    return x * reciprocal_root(max(x, 0x1p-100f));
}

// (cos, sin) of an angle in turns, in [-2^20, 2^20].
fn cosine_sine(turns: f32) -> vec2<f32> {
    let t = turns - floor(turns + 0.5f);
    let a = abs(t);
    // Fold onto [-1/4, 1/4] turns, where both series are short.
    let folded = select(t, select(0.5f, -0.5f, t < 0.0f) - t, a > 0.25f);
    let z = folded * 6.28318530718f;
    let w = z * z;
    let sine = z * (1.0f + w * (-0.16666667f + w * (0.008333333f + w * (-0.00019841270f + w * (2.7557319e-6f + w * -2.5052108e-8f)))));
    let cosine = 1.0f + w * (-0.5f + w * (0.041666667f + w * (-0.0013888889f + w * (2.4801587e-5f + w * (-2.7557319e-7f + w * 2.0876757e-9f)))));
    return vec2<f32>(select(cosine, -cosine, a > 0.25f), sine);
}

// The direction of (x, y) in turns, in [0, 1); 0 for (0, 0). |x| and |y| in [2^-60, 2^60] or 0.
fn direction(v: vec2<f32>) -> f32 {
    let ax = abs(v.x);
    let ay = abs(v.y);
    let low = min(ax, ay);
    let high = max(ax, ay);
    let q = low * reciprocal(max(high, 0x1p-100f));
    let w = q * q;
    var t = q * (0.15915494f + w * (-0.05305165f + w * (0.03182f + w * (-0.02247f + w * (0.01639f + w * (-0.01014f + w * 0.0035f))))));
    t = select(t, 0.25f - t, ay > ax);
    t = select(t, 0.5f - t, v.x < 0.0f);
    t = select(t, 1.0f - t, v.y < 0.0f && t > 0.0f);
    return select(t, 0.0f, t >= 1.0f);
}

// e^x for x in [-87, 88]; clamped to that range.
fn exponential(x: f32) -> f32 {
    let bounded = clamp(x, -87.0f, 88.0f);
    let whole = floor(bounded * 1.44269504f + 0.5f);
    let r = (bounded - whole * 0.693359375f) + whole * 2.12194440e-4f;
    let p = 1.0f + r * (1.0f + r * (0.5f + r * (0.16666667f + r * (0.041666667f + r * (0.0083333333f + r * 0.0013888889f)))));
    return p * bitcast<f32>(u32(i32(whole) + 127) << 23u);
}

// 1/(1 + e^-x), every x.
fn logistic(x: f32) -> f32 {
    return reciprocal(1.0f + exponential(-x));
}
