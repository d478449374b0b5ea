//! The functions of `lib/numerics.wgsl`, operation by operation.
#![allow(
    clippy::approx_constant,
    clippy::excessive_precision,
    clippy::many_single_char_names,
    reason = "constants and names are those of the WGSL"
)]

pub(super) fn reciprocal(x: f32) -> f32 {
    let guess = f32::from_bits(0x7ef3_3000_u32.wrapping_sub(x.to_bits()));
    let r = x * guess;
    let y = guess * (3.001_926_7 + r * (r - 3.001_886_6));
    y * (2.0 - x * y)
}

pub(super) fn reciprocal_root(x: f32) -> f32 {
    let guess = f32::from_bits(0x5f09_8000 - (x.to_bits() >> 1));
    let r = x * guess * guess;
    let y = guess * (1.897_508_6 + r * (r - 2.054_892_8));
    y * (1.889_881_6 - x * y * y)
}

pub(super) fn root(x: f32) -> f32 {
    x * reciprocal_root(most(x, f32::from_bits((127 - 100) << 23)))
}

/// Rounds towards minus infinity, for magnitudes below 2^22: sums with the constant have no bits below 1. The standard
/// library's function would be a library call, and conversions to an integer and back take longer.
pub(super) fn floor(x: f32) -> f32 {
    const WHOLE: f32 = 12_582_912.0;
    let nearest = (x + WHOLE) - WHOLE;
    if nearest > x { nearest - 1.0 } else { nearest }
}

/// Squares of smaller numbers could be subnormal.
const SMALL: f32 = f32::from_bits((127 - 40) << 23);

/// The larger of two numbers; a single instruction, unlike `f32::max`.
pub(super) fn most(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller of two numbers.
pub(super) fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

fn quarter_sine(t: f32) -> f32 {
    let bounded = most(t.abs(), SMALL);
    let w = bounded * bounded;
    t * (6.283_184_5 + w * (-41.341_62 + w * (81.600_365 + w * (-76.542_52 + w * 39.486_614))))
}

pub(super) fn cosine_sine(turns: f32) -> (f32, f32) {
    let t = turns - floor(turns + 0.5);
    let size = t.abs();
    let folded = if size > 0.25 {
        (if t < 0.0 { -0.5 } else { 0.5 }) - t
    } else {
        t
    };
    (quarter_sine(0.25 - size), quarter_sine(folded))
}

pub(super) fn direction_by(x: f32, y: f32, inverse_length: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let s = (if ax < ay { ax } else { ay }) * inverse_length;
    let bounded = most(s, SMALL);
    let w = bounded * bounded;
    let t = s * (0.159_160_61 + w * (0.026_317_78 + w * (0.014_036_615 + w * (-0.001_182_702_5 + w * 0.017_525_312))));
    let t = if ay > ax { 0.25 - t } else { t };
    let t = if x < 0.0 { 0.5 - t } else { t };
    let t = if y < 0.0 { 1.0 - t } else { t };
    if t >= 1.0 { 0.0 } else { t }
}

fn exponential(x: f32) -> f32 {
    let k = floor(x * 1.442_695);
    let half = k + 0.5;
    let r = (x - half * 0.693_359_38) + half * 2.121_944_4e-4;
    let p = 1.414_213_7_f32
        + r * (1.414_213 + r * (0.707_089_07 + r * (0.235_716_24 + r * (0.059_303_034 + r * 0.011_750_611))));
    f32::from_bits(p.to_bits().wrapping_add_signed((k as i32) << 23))
}

pub(super) fn logistic(x: f32) -> f32 {
    let x = most(-x, -43.0);
    reciprocal(1.0 + exponential(if x < 43.0 { x } else { 43.0 }))
}
