// Functions that kernels need and WGSL gives no exact promise for, written from exactly rounded operations
// only. An error is the maximum over every float of the range, unless said otherwise; docs/numerics.md has
// how the constants were found, and tests/library/numerics.rs measures the errors again. In its range no function
// makes a NaN, an infinity or a subnormal number, not even on the way.

// 1/x for |x| in [2^-126, 0x1.ep125]. Relative error 1.19e-7; exact for powers of two.
// The first guess subtracts the bits of x, which negates its exponent (within 5 %); a step with cubic
// convergence, its coefficients fitted to the guess, and one of Newton's follow: y' = y (2 - x y).
fn reciprocal(x: f32) -> f32 {
    let guess = bitcast<f32>(0x7ef33000u - bitcast<u32>(x));
    let r = x * guess;
    let y = guess * (3.0019267f + r * (r - 3.0018866f));
    return y * (2.0f - x * y);
}

// 1/sqrt(x) for x >= 2^-126. Relative error 1.6e-7; exact for powers of four.
// The first guess halves the bits of x and subtracts them (Lomont, "Fast inverse square root", 2003). It is
// made to converge to c y with c^3 = 1/2 in a fitted cubic step, so that Newton's y (1.5 - x y y / 2), which
// is then y (3 c^2 - x y y), needs no halving.
fn reciprocal_root(x: f32) -> f32 {
    let guess = bitcast<f32>(0x5f098000u - (bitcast<u32>(x) >> 1u));
    let r = x * guess * guess;
    let y = guess * (1.8975086f + r * (r - 2.0548928f));
    return y * (1.8898816f - x * y * y);
}

// sqrt(x) for x = 0 or x >= 2^-100. Relative error 2.0e-7; exact for 0 and powers of four. Of a negative x 2^50 x.
fn root(x: f32) -> f32 {
    return x * reciprocal_root(max(x, 0x1p-100f));
}

// The sum of two squares, whose root is a vector's length.
fn squared_length(v: vec2<f32>) -> f32 {
    return v.x * v.x + v.y * v.y;
}

// sin of t turns, |t| <= 1/4: an odd polynomial. The square is kept from underflow.
fn quarter_sine(t: f32) -> f32 {
    let bounded = max(abs(t), 0x1p-40f);
    let w = bounded * bounded;
    return t * (6.2831845f + w * (-41.34162f + w * (81.600365f + w * (-76.54252f + w * 39.486614f))));
}

// (cos, sin) of an angle in turns, |turns| <= 2^23. Absolute error 1.9e-7; exact for quarters of a turn.
fn cosine_sine(turns: f32) -> vec2<f32> {
    let t = turns - floor(turns + 0.5f);
    let size = abs(t);
    let folded = select(t, select(0.5f, -0.5f, t < 0.0f) - t, size > 0.25f);
    return vec2<f32>(quarter_sine(0.25f - size), quarter_sine(folded));
}

// The direction of v in turns, in [0, 1), given 1/length. |v.x| and |v.y| are 0 or in [2^-60, 2^60].
// Absolute error 4.5e-7 with the inverse from reciprocal_root (over dense grids and random vectors). The direction
// in the first quarter, then the reflections that lead from there to the rest.
fn direction_by(v: vec2<f32>, inverse_length: f32) -> f32 {
    var t = quarter_direction(abs(v.x), abs(v.y), inverse_length);
    t = select(t, 0.5f - t, v.x < 0.0f);
    t = select(t, 1.0f - t, v.y < 0.0f);
    return select(t, 0.0f, t >= 1.0f);
}

// The same of a vector in the first quarter, in [0, 1/4]: the arc sine of the shorter component, an odd polynomial,
// then a reflection that leads from the first half quadrant to the other.
fn quarter_direction(x: f32, y: f32, inverse_length: f32) -> f32 {
    let s = min(x, y) * inverse_length;
    let bounded = max(s, 0x1p-40f);
    let w = bounded * bounded;
    let t = s * (0.15916061f + w * (0.02631778f + w * (0.014036615f + w * (-0.0011827025f + w * 0.017525312f))));
    return select(t, 0.25f - t, y > x);
}

// The direction of v in turns, in [0, 1); range and error as of direction_by. Exact along the axes, and 0
// for no direction, (0, 0).
fn direction(v: vec2<f32>) -> f32 {
    return direction_by(v, reciprocal_root(max(v.x * v.x + v.y * v.y, 0x1p-126f)));
}

// e^x for |x| <= 87. Relative error 1.9e-7; exact for 0.
// x = (k + 1/2) ln 2 + r, with ln 2 in two parts (Cody and Waite, 1980); a polynomial for sqrt(2) e^r in
// [1, 2]; k, the last bits of a sum with 3 * 2^22, is added to its exponent. Halves, since r then is never so small that
// its powers underflow.
fn exponential_within(x: f32) -> f32 {
    let k = floor(x * 1.442695f);
    let half = k + 0.5f;
    let r = (x - half * 0.69335938f) + half * 2.1219444e-4f;
    let p = 1.4142137f + r * (1.414213f + r * (0.70708907f + r * (0.23571624f + r * (0.059303034f + r * 0.011750611f))));
    return bitcast<f32>(bitcast<u32>(p) + (bitcast<u32>(k + 0x1.8p23f) << 23u));
}

// e^x, x clamped to [-87, 87]; error as of exponential_within.
fn exponential(x: f32) -> f32 {
    return exponential_within(clamp(x, -87.0f, 87.0f));
}

// 1/(1 + e^-x), every x; it stays at its values for -43 and 43 beyond, so that an output, at least 2^-63, times
// a gene is never subnormal, nor is a sum of such. Absolute error 1.5e-7; exact for 0.
fn logistic(x: f32) -> f32 {
    return reciprocal(1.0f + exponential_within(clamp(-x, -43.0f, 43.0f)));
}

// The natural logarithm of x >= 2^-126. Relative error 1e-7; exact for 1.
// x = m 2^k with m in [sqrt(1/2), sqrt(2)) by its bits; ln m = g - g^2/2 + g^3 p(g), g = m - 1; ln 2 in two
// parts.
fn logarithm(x: f32) -> f32 {
    let from_low = bitcast<u32>(x) - 0x3f3504f3u;
    let k = f32(bitcast<i32>(from_low) >> 23u);
    let g = bitcast<f32>((from_low & 0x7fffffu) + 0x3f3504f3u) - 1.0f;
    let w = g * g;
    let p = 0.33333907f + g * (-0.25001344f + g * (0.19963022f + g * (-0.16577557f + g * (0.14914769f + g * (-0.14267488f + g * 0.08703363f)))));
    let rest = (g * w * p - k * 2.1219444e-4f) - 0.5f * w;
    return (g + rest) + k * 0.69335938f;
}

// The place of the lowest bit of a word that has one.
fn lowest_bit(word: u32) -> u32 {
    let bit = word & (0u - word);
    return select(0u, 1u, (bit & 0xaaaaaaaau) != 0u) | select(0u, 2u, (bit & 0xccccccccu) != 0u)
        | select(0u, 4u, (bit & 0xf0f0f0f0u) != 0u) | select(0u, 8u, (bit & 0xff00ff00u) != 0u)
        | select(0u, 16u, (bit & 0xffff0000u) != 0u);
}
