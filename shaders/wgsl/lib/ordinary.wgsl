// WGSL's own functions and operators that devices compute in different ways, written from exactly rounded operations.
// A kernel whose parts use one gets the function that stands for it: wgsl_ and its name.
// Errors are maxima over the range, in units in the last place (ulp) unless said otherwise; docs/numerics.md lists them,
// and shaders/native/tests/native/ordinary.rs measures them again. Outside its range a function still has the same bits
// everywhere.

// a / b for |a| and |b| of 0 or from 2^-126. Error 0.5 ulp, so that a quotient that is a float is exact. Quotients
// beyond the range of floats are the largest float, those below 2^-126 are 0; a / 0 is as of b = 2^-127.
// Significands in [1, 2) are divided; what the product of two halves of their bits (Dekker, 1971) leaves corrects the
// quotient, whose exponent is then added.
fn wgsl_divide(a: f32, b: f32) -> f32 {
    let m = wgsl_significand(a);
    let n = wgsl_significand(b);
    let y = reciprocal(n);
    let q = m * y;
    let p = q * n;
    let quotient = q + ((m - p) - wgsl_rest_of_product(q, n, p)) * y;
    let exponent = wgsl_exponent(a) - wgsl_exponent(b) + wgsl_exponent(quotient);
    let bits = (bitcast<u32>(quotient) & 0x7fffffu) | (bitcast<u32>(clamp(exponent, 1, 254)) << 23u);
    let size = select(bitcast<f32>(select(bits, 0x7f7fffffu, exponent > 254)), 0.0f, (a == 0.0f) | (exponent < 1));
    return select(size, -size, (a < 0.0f) != (b < 0.0f));
}

// The significand of x, in [1, 2).
fn wgsl_significand(x: f32) -> f32 {
    return bitcast<f32>((bitcast<u32>(x) & 0x7fffffu) | 0x3f800000u);
}

// The exponent of x as its bits have it, 127 for numbers in [1, 2).
fn wgsl_exponent(x: f32) -> i32 {
    return bitcast<i32>((bitcast<u32>(x) >> 23u) & 0xffu);
}

// a b - p, exact if p is the rounded product of a and b, both in [1/2, 4).
fn wgsl_rest_of_product(a: f32, b: f32, p: f32) -> f32 {
    let a_high = 4097.0f * a - (4097.0f * a - a);
    let b_high = 4097.0f * b - (4097.0f * b - b);
    let a_low = a - a_high;
    let b_low = b - b_high;
    return ((a_high * b_high - p) + (a_high * b_low + a_low * b_high)) + a_low * b_low;
}

// a % b: a - b trunc(a / b), as WGSL defines it; range of a / b.
fn wgsl_modulo(a: f32, b: f32) -> f32 {
    return a - b * trunc(wgsl_divide(a, b));
}

// a / b of signed integers, towards zero; a for b = 0, as WGSL defines it.
fn wgsl_divide_i32(a: i32, b: i32) -> i32 {
    let size = bitcast<i32>(bitcast<u32>(abs(a)) / max(bitcast<u32>(abs(b)), 1u));
    return select(select(size, -size, (a < 0) != (b < 0)), a, b == 0);
}

// a % b of signed integers, with the sign of a; 0 for b = 0.
fn wgsl_modulo_i32(a: i32, b: i32) -> i32 {
    let size = bitcast<i32>(bitcast<u32>(abs(a)) % max(bitcast<u32>(abs(b)), 1u));
    return select(select(size, -size, a < 0), 0, b == 0);
}

// Shifts by a count modulo 32.
fn wgsl_shift_left_u32(a: u32, count: u32) -> u32 {
    return a << (count & 31u);
}
fn wgsl_shift_left_i32(a: i32, count: u32) -> i32 {
    return a << (count & 31u);
}
fn wgsl_shift_right_u32(a: u32, count: u32) -> u32 {
    return a >> (count & 31u);
}
fn wgsl_shift_right_i32(a: i32, count: u32) -> i32 {
    return a >> (count & 31u);
}

// sqrt(x) for x of 0 or from 2^-126. Error 0.5 ulp, so that a root that is a float is exact. 0 for negative x.
// As for a quotient, of x times an even power of two, in [1, 4).
fn wgsl_sqrt(x: f32) -> f32 {
    let positive = max(x, 0x1p-126f);
    let exponent = (bitcast<u32>(positive) - 0x3f800000u) & 0xff000000u;
    let m = bitcast<f32>(bitcast<u32>(positive) - exponent);
    let y = reciprocal_root(m);
    let s = m * y;
    let p = s * s;
    let root = s + ((m - p) - wgsl_rest_of_product(s, s, p)) * (0.5f * y);
    let scaled = bitcast<u32>(root) + bitcast<u32>(bitcast<i32>(exponent) >> 1u);
    return select(0.0f, bitcast<f32>(scaled), x >= 0x1p-126f);
}

// 1 / sqrt(x) for x from 2^-126. Error 2.1 ulp.
fn wgsl_inverseSqrt(x: f32) -> f32 {
    return reciprocal_root(max(x, 0x1p-126f));
}

// x in quarters of a turn: (their number, rounded, and the rest as an angle in [-pi/4, pi/4]). pi/2 in four parts, of
// which the first three have so few bits that their products with the number are exact (Cody and Waite, 1980).
fn wgsl_quarters(x: f32) -> vec2<f32> {
    let bounded = clamp(x, -0x1p22f, 0x1p22f);
    let k = floor(bounded * 0.63661975f + 0.5f);
    let rest = ((bounded - k * 1.5703125f) - k * 0x1.fb4p-12f) - k * 0x1.444p-24f;
    return vec2<f32>(k, rest - k * 0x1.68c234p-39f);
}

// sin and cos of an angle in [-pi/4, pi/4]: polynomials. The square is kept from underflow.
fn wgsl_sine_within(angle: f32) -> f32 {
    let bounded = max(abs(angle), 0x1p-40f);
    let w = bounded * bounded;
    return angle * (1.0f + w * (-0.16666655f + w * (0.008332156f + w * -1.9514632e-4f)));
}
fn wgsl_cosine_within(angle: f32) -> f32 {
    let bounded = max(abs(angle), 0x1p-40f);
    let w = bounded * bounded;
    return 1.0f + w * (-0.5f + w * (0.041666646f + w * (-0.001388731f + w * 2.4432413e-5f)));
}

// sin(x) for |x| <= 8000. Error 2.8 ulp.
fn wgsl_sin(x: f32) -> f32 {
    let quarters = wgsl_quarters(x);
    let number = bitcast<u32>(i32(quarters.x));
    let size = select(wgsl_sine_within(quarters.y), wgsl_cosine_within(quarters.y), (number & 1u) == 1u);
    return select(size, -size, (number & 2u) == 2u);
}

// cos(x); range and error as of sin.
fn wgsl_cos(x: f32) -> f32 {
    let quarters = wgsl_quarters(x);
    let number = bitcast<u32>(i32(quarters.x));
    let size = select(wgsl_cosine_within(quarters.y), wgsl_sine_within(quarters.y), (number & 1u) == 1u);
    return select(size, -size, ((number + 1u) & 2u) == 2u);
}

// tan(x) for |x| <= 8000. Error 4.1 ulp.
fn wgsl_tan(x: f32) -> f32 {
    let quarters = wgsl_quarters(x);
    let is_odd = (bitcast<u32>(i32(quarters.x)) & 1u) == 1u;
    let sine = wgsl_sine_within(quarters.y);
    let cosine = wgsl_cosine_within(quarters.y);
    return wgsl_divide(select(sine, -cosine, is_odd), select(cosine, sine, is_odd));
}

// atan2 of a point in the first quarter, in [0, pi/2]. The angle to the nearer axis or, from pi/8 on, to the diagonal
// is an odd polynomial of its tangent.
fn wgsl_first_quarter(y: f32, x: f32) -> f32 {
    let less = min(x, y);
    let more = max(x, y);
    let is_diagonal = less > 0.41421357f * more;
    let t = wgsl_divide(select(less, less - more, is_diagonal), select(more, less + more, is_diagonal));
    let bounded = max(abs(t), 0x1p-40f);
    let w = bounded * bounded;
    let p = w * (-0.33332947f + w * (0.1997759f + w * (-0.1387627f + w * 0.080488384f)));
    let near = t * (1.0f + p);
    let angle = select(near, 0.7853982f + near, is_diagonal);
    return select(angle, 1.5707964f - angle, y > x);
}

// atan2(y, x) for |x| and |y| of 0 or from 2^-126 to 2^126, in [-pi, pi]. Error 3.2 ulp; 0 for (0, 0).
fn wgsl_atan2(y: f32, x: f32) -> f32 {
    let angle = wgsl_first_quarter(abs(y), abs(x));
    let half = select(angle, 3.1415927f - angle, x < 0.0f);
    return select(half, -half, y < 0.0f);
}

// atan(x) for |x| <= 2^126. Error 3.2 ulp.
fn wgsl_atan(x: f32) -> f32 {
    let angle = wgsl_first_quarter(abs(x), 1.0f);
    return select(angle, -angle, x < 0.0f);
}

// asin of a number in [0, 1/2]: an odd polynomial.
fn wgsl_arc_sine_within(x: f32) -> f32 {
    let bounded = max(x, 0x1p-40f);
    let w = bounded * bounded;
    let p = w * (0.16666752f + w * (0.074952886f + w * (0.04547161f + w * (0.024172952f + w * 0.04217823f))));
    return x * (1.0f + p);
}

// asin(x) for |x| <= 1, to which x is clamped. Error 3.4 ulp. asin x = pi/2 - 2 asin sqrt((1 - x) / 2).
fn wgsl_asin(x: f32) -> f32 {
    let size = min(abs(x), 1.0f);
    let is_large = size > 0.5f;
    let angle = wgsl_arc_sine_within(select(size, wgsl_sqrt(0.5f * (1.0f - size)), is_large));
    let result = select(angle, 1.5707964f - 2.0f * angle, is_large);
    return select(result, -result, x < 0.0f);
}

// acos(x) for |x| <= 1, to which x is clamped. Error 2.1 ulp.
fn wgsl_acos(x: f32) -> f32 {
    let size = min(abs(x), 1.0f);
    let is_large = size > 0.5f;
    let angle = wgsl_arc_sine_within(select(size, wgsl_sqrt(0.5f * (1.0f - size)), is_large));
    let is_negative = x < 0.0f;
    let small = 1.5707964f - select(angle, -angle, is_negative);
    return select(small, select(2.0f * angle, 3.1415927f - 2.0f * angle, is_negative), is_large);
}

// tanh(x), every x. Error 2 ulp. An odd polynomial, and 1 - 2 / (e^2x + 1) from 5/8 on.
fn wgsl_tanh(x: f32) -> f32 {
    let size = min(abs(x), 10.0f);
    let bounded = max(size, 0x1p-40f);
    let w = bounded * bounded;
    let p = w * (-0.3333328f + w * (0.1333142f + w * (-0.053737797f + w * (0.020632546f + w * -0.005697384f))));
    let large = 1.0f - 2.0f * reciprocal(wgsl_exp2(2.88539f * size) + 1.0f);
    let result = select(size * (1.0f + p), large, size > 0.625f);
    return select(result, -result, x < 0.0f);
}

// e^x and e^-x, half of each, for x in [0, 87]. The latter is kept from underflow: from 21 on it counts for nothing.
fn wgsl_half_exponentials(x: f32) -> vec2<f32> {
    let growing = exponential_within(x);
    return vec2<f32>(0.5f * growing, 0.5f * reciprocal(min(growing, 0x1p30f)));
}

// sinh(x), x clamped to [-87, 87]. Error 3.6 ulp. Below 1 the first terms of its series.
fn wgsl_sinh(x: f32) -> f32 {
    let size = min(abs(x), 87.0f);
    let bounded = max(min(size, 1.0f), 0x1p-40f);
    let w = bounded * bounded;
    let p = w * (0.16666667f + w * (0.008333334f + w * (1.984127e-4f + w * (2.7557319e-6f + w * 2.5052108e-8f))));
    let halves = wgsl_half_exponentials(size);
    let result = select(size * (1.0f + p), halves.x - halves.y, size > 1.0f);
    return select(result, -result, x < 0.0f);
}

// cosh(x), x clamped to [-87, 87]. Error 3.1 ulp.
fn wgsl_cosh(x: f32) -> f32 {
    let halves = wgsl_half_exponentials(min(abs(x), 87.0f));
    return halves.x + halves.y;
}

// ln(1 + x) for x of 0 or from 2^-126 to 2^126, without the rounding of 1 + x: as of logarithm, with g = (1 + x) 2^-k - 1 of
// x itself.
fn wgsl_logarithm_beyond_one(x: f32) -> f32 {
    let exponent = (bitcast<u32>(1.0f + x) - 0x3f3504f3u) >> 23u;
    let scale = bitcast<f32>(0x3f800000u - (exponent << 23u));
    let k = f32(exponent);
    let g = x * scale + (scale - 1.0f);
    let bounded = select(g, 0.0f, abs(g) < 0x1p-40f);
    let w = bounded * bounded;
    let p = 0.33333907f + bounded * (-0.25001344f + bounded * (0.19963022f + bounded * (-0.16577557f + bounded * (0.14914769f + bounded * (-0.14267488f + bounded * 0.08703363f)))));
    let rest = (bounded * w * p - k * 2.1219444e-4f) - 0.5f * w;
    return (g + rest) + k * 0.69335938f;
}

// asinh(x), every x. Error 2.7 ulp. asinh x = ln(1 + (x + x^2 / (1 + sqrt(1 + x^2)))), and ln(x / 4) + 3 ln 2 from 2^30 on.
fn wgsl_asinh(x: f32) -> f32 {
    let size = abs(x);
    let is_large = size > 0x1p30f;
    let bounded = clamp(size, 0x1p-40f, 0x1p30f);
    let more = min(size, 0x1p30f) * (1.0f + wgsl_divide(bounded, 1.0f + wgsl_sqrt(1.0f + bounded * bounded)));
    let near = wgsl_logarithm_beyond_one(select(more, 0.25f * size, is_large));
    let result = near + select(0.0f, 2.0794415f, is_large);
    return select(result, -result, x < 0.0f);
}

// acosh(x) for x from 1, to which x is raised. Error 2.8 ulp. acosh x = ln(1 + (t + sqrt(t (2 + t)))) with t = x - 1, and
// ln(x / 4) + 3 ln 2 from 2^30 on.
fn wgsl_acosh(x: f32) -> f32 {
    let is_large = x > 0x1p30f;
    let t = clamp(x, 1.0f, 0x1p30f) - 1.0f;
    let near = wgsl_logarithm_beyond_one(select(t + wgsl_sqrt(t * (2.0f + t)), 0.25f * x, is_large));
    return near + select(0.0f, 2.0794415f, is_large);
}

// atanh(x) for |x| < 1; x is clamped to 1 - 2^-24 and its negative. Error 2.4 ulp. atanh x = ln(1 + 2x / (1 - x)) / 2.
fn wgsl_atanh(x: f32) -> f32 {
    let size = min(abs(x), 0x1.fffffep-1f);
    let result = 0.5f * wgsl_logarithm_beyond_one(wgsl_divide(2.0f * size, 1.0f - size));
    return select(result, -result, x < 0.0f);
}

// e^x, x clamped to [-87, 87]. Error 2.8 ulp.
fn wgsl_exp(x: f32) -> f32 {
    return exponential(x);
}

// 2^x, x clamped to [-126, 127.99999]. Error 1.3 ulp; exact for integers.
fn wgsl_exp2(x: f32) -> f32 {
    let bounded = clamp(x, -126.0f, 127.99999f);
    let k = floor(bounded + 0.5f);
    let rest = bounded - k;
    let f = select(rest, 0.0f, abs(rest) < 0x1p-40f);
    let p = 1.0f + f * (0.6931472f + f * (0.24022648f + f * (0.055503324f + f * (0.009618437f + f * (0.0013398874f + f * 1.5353362e-4f)))));
    return bitcast<f32>(bitcast<u32>(p) + (bitcast<u32>(i32(k)) << 23u));
}

// ln(x) for x from 2^-126, to which x is raised. Error 1.2 ulp.
fn wgsl_log(x: f32) -> f32 {
    return logarithm(max(x, 0x1p-126f));
}

// log2(x) for x from 2^-126, to which x is raised. Error 1.8 ulp; exact for powers of two.
// x = m 2^k as of logarithm; ln m = g + rest, and log2(e) in two parts.
fn wgsl_log2(x: f32) -> f32 {
    let from_low = bitcast<u32>(max(x, 0x1p-126f)) - 0x3f3504f3u;
    let k = f32(bitcast<i32>(from_low) >> 23u);
    let g = bitcast<f32>((from_low & 0x7fffffu) + 0x3f3504f3u) - 1.0f;
    let w = g * g;
    let p = 0.33333907f + g * (-0.25001344f + g * (0.19963022f + g * (-0.16577557f + g * (0.14914769f + g * (-0.14267488f + g * 0.08703363f)))));
    let rest = g * w * p - 0.5f * w;
    let high = g + rest;
    let low = (g - high) + rest;
    return ((high * 0.005195041f + low * 1.442695f) + high * 1.4375f) + k;
}

// x^y for x from 2^-126: 2^(y log2 x). Relative error 2e-7 (1 + |y log2 x|); 0 for x of 0 or less.
fn wgsl_pow(x: f32, y: f32) -> f32 {
    return select(0.0f, wgsl_exp2(y * wgsl_log2(x)), x >= 0x1p-126f);
}
// x^y for constants y of -2, -1, -1/2, 1/2, 1, 2, 3 and 4, for negative x too where y is an integer. Error 2.1 ulp.
fn wgsl_pow_minus_two(x: f32) -> f32 {
    return wgsl_divide(1.0f, x * x);
}
fn wgsl_pow_minus_one(x: f32) -> f32 {
    return wgsl_divide(1.0f, x);
}
fn wgsl_pow_minus_half(x: f32) -> f32 {
    return wgsl_inverseSqrt(x);
}
fn wgsl_pow_half(x: f32) -> f32 {
    return wgsl_sqrt(x);
}
fn wgsl_pow_one(x: f32) -> f32 {
    return x;
}
fn wgsl_pow_two(x: f32) -> f32 {
    return x * x;
}
fn wgsl_pow_three(x: f32) -> f32 {
    return x * x * x;
}
fn wgsl_pow_four(x: f32) -> f32 {
    return (x * x) * (x * x);
}

// x 2^n. Exact; beyond the range of floats the largest float, below 2^-126 0.
fn wgsl_ldexp(x: f32, n: i32) -> f32 {
    let exponent = wgsl_exponent(x) + clamp(n, -600, 600);
    let bits = (bitcast<u32>(x) & 0x7fffffu) | (bitcast<u32>(clamp(exponent, 1, 254)) << 23u);
    let size = select(bitcast<f32>(select(bits, 0x7f7fffffu, exponent > 254)), 0.0f, (x == 0.0f) | (exponent < 1));
    return select(size, -size, x < 0.0f);
}

// x as a number in [1/2, 1) times a power of two: the number with the sign of x, and the exponent. Exact; 0 and 0 for 0.
fn wgsl_frexp_fract(x: f32) -> f32 {
    let size = select(0.5f * wgsl_significand(x), 0.0f, x == 0.0f);
    return select(size, -size, x < 0.0f);
}
fn wgsl_frexp_exp(x: f32) -> i32 {
    return select(wgsl_exponent(x) - 126, 0, x == 0.0f);
}

// The functions from here on are computed as WGSL defines them, each operation rounded.
fn wgsl_ceil(x: f32) -> f32 {
    return -floor(-x);
}
// Halves to the even number.
fn wgsl_round(x: f32) -> f32 {
    let down = floor(x);
    let rest = x - down;
    let is_odd = down != 2.0f * floor(0.5f * down);
    return down + select(0.0f, 1.0f, (rest > 0.5f) | ((rest == 0.5f) & is_odd));
}
fn wgsl_fract(x: f32) -> f32 {
    return x - floor(x);
}
fn wgsl_modf_fract(x: f32) -> f32 {
    return x - trunc(x);
}
fn wgsl_modf_whole(x: f32) -> f32 {
    return trunc(x);
}
fn wgsl_sign(x: f32) -> f32 {
    return select(select(0.0f, 1.0f, x > 0.0f), -1.0f, x < 0.0f);
}
fn wgsl_sign_i32(x: i32) -> i32 {
    return clamp(x, -1, 1);
}
fn wgsl_saturate(x: f32) -> f32 {
    return clamp(x, 0.0f, 1.0f);
}
fn wgsl_radians(x: f32) -> f32 {
    return x * 0.017453292f;
}
fn wgsl_degrees(x: f32) -> f32 {
    return x * 57.29578f;
}
fn wgsl_fma(a: f32, b: f32, c: f32) -> f32 {
    return a * b + c;
}
fn wgsl_mix(a: f32, b: f32, t: f32) -> f32 {
    return a * (1.0f - t) + b * t;
}
fn wgsl_step(edge: f32, x: f32) -> f32 {
    return select(0.0f, 1.0f, edge <= x);
}
fn wgsl_smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = clamp(wgsl_divide(x - low, high - low), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}
fn wgsl_cross_vec3(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
// Of matrices: sums of products, each sum from left to right.
fn wgsl_determinant_mat2x2(m: mat2x2<f32>) -> f32 {
    return m[0].x * m[1].y - m[1].x * m[0].y;
}
fn wgsl_determinant_mat3x3(m: mat3x3<f32>) -> f32 {
    let products = m[0] * wgsl_cross_vec3(m[1], m[2]);
    return products.x + products.y + products.z;
}
// By the determinants of two rows of the first two columns and of the other two rows of the others (Laplace).
fn wgsl_determinant_mat4x4(m: mat4x4<f32>) -> f32 {
    let a = m[0];
    let b = m[1];
    let first = vec3<f32>(a.x * b.y - b.x * a.y, a.x * b.z - b.x * a.z, a.x * b.w - b.x * a.w);
    let second = vec3<f32>(a.z * b.w - b.z * a.w, b.y * a.w - a.y * b.w, a.y * b.z - b.y * a.z);
    let c = m[2];
    let d = m[3];
    let third = vec3<f32>(c.z * d.w - d.z * c.w, d.y * c.w - c.y * d.w, c.y * d.z - d.y * c.z);
    let fourth = vec3<f32>(c.x * d.y - d.x * c.y, c.x * d.z - d.x * c.z, c.x * d.w - d.x * c.w);
    let products = first * third;
    let others = second * fourth;
    return (products.x + products.y + products.z) + (others.x + others.y + others.z);
}
fn wgsl_length(x: f32) -> f32 {
    return abs(x);
}
fn wgsl_distance(a: f32, b: f32) -> f32 {
    return abs(a - b);
}
fn wgsl_any(x: bool) -> bool {
    return x;
}
fn wgsl_all(x: bool) -> bool {
    return x;
}

// Bits of integers: sums of neighbouring bits, of twos, of nibbles (Warren, "Hacker's Delight", 2002).
fn wgsl_countOneBits_u32(x: u32) -> u32 {
    let twos = x - ((x >> 1u) & 0x55555555u);
    let nibbles = (twos & 0x33333333u) + ((twos >> 2u) & 0x33333333u);
    return (((nibbles + (nibbles >> 4u)) & 0x0f0f0f0fu) * 0x01010101u) >> 24u;
}
fn wgsl_countTrailingZeros_u32(x: u32) -> u32 {
    return wgsl_countOneBits_u32(~x & (x - 1u));
}
fn wgsl_countLeadingZeros_u32(x: u32) -> u32 {
    let a = x | (x >> 1u);
    let b = a | (a >> 2u);
    let c = b | (b >> 4u);
    let d = c | (c >> 8u);
    return wgsl_countOneBits_u32(~(d | (d >> 16u)));
}
// 2^32 - 1 if there is none, as WGSL defines it.
fn wgsl_firstTrailingBit_u32(x: u32) -> u32 {
    return select(wgsl_countTrailingZeros_u32(x), 0xffffffffu, x == 0u);
}
fn wgsl_firstLeadingBit_u32(x: u32) -> u32 {
    return 31u - wgsl_countLeadingZeros_u32(x);
}
fn wgsl_reverseBits_u32(x: u32) -> u32 {
    let a = ((x >> 1u) & 0x55555555u) | ((x & 0x55555555u) << 1u);
    let b = ((a >> 2u) & 0x33333333u) | ((a & 0x33333333u) << 2u);
    let c = ((b >> 4u) & 0x0f0f0f0fu) | ((b & 0x0f0f0f0fu) << 4u);
    let d = ((c >> 8u) & 0x00ff00ffu) | ((c & 0x00ff00ffu) << 8u);
    return (d >> 16u) | (d << 16u);
}
// Of a negative number, the first bit that is 0.
fn wgsl_firstLeadingBit_i32(x: i32) -> i32 {
    return bitcast<i32>(wgsl_firstLeadingBit_u32(bitcast<u32>(select(x, ~x, x < 0))));
}
fn wgsl_countOneBits_i32(x: i32) -> i32 {
    return bitcast<i32>(wgsl_countOneBits_u32(bitcast<u32>(x)));
}
fn wgsl_countTrailingZeros_i32(x: i32) -> i32 {
    return bitcast<i32>(wgsl_countTrailingZeros_u32(bitcast<u32>(x)));
}
fn wgsl_countLeadingZeros_i32(x: i32) -> i32 {
    return bitcast<i32>(wgsl_countLeadingZeros_u32(bitcast<u32>(x)));
}
fn wgsl_firstTrailingBit_i32(x: i32) -> i32 {
    return bitcast<i32>(wgsl_firstTrailingBit_u32(bitcast<u32>(x)));
}
fn wgsl_reverseBits_i32(x: i32) -> i32 {
    return bitcast<i32>(wgsl_reverseBits_u32(bitcast<u32>(x)));
}
