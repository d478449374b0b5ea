//! Functions made only of exactly rounded operations, so that values derived with them are the same on every machine,
//! unlike with the standard library.

/// Ranges of the arguments of functions in `lib/numerics.wgsl`: the smallest number that they take.
pub(crate) const LEAST: f32 = f32::MIN_POSITIVE;
/// The reciprocal's largest argument, 0x1.ep125.
pub(crate) const RECIPROCAL_GREATEST: f32 = 7.975_367_5e37;
/// The root's smallest argument except 0, 2^-100.
pub(crate) const ROOT_LEAST: f32 = 7.888_609e-31;
/// The largest argument of cosine and sine, 2^23.
pub(crate) const TURNS_GREATEST: f32 = 8_388_608.0;

/// Gives zero its one sign.
pub(crate) fn zero(x: f32) -> f32 {
    if x == 0.0 { 0.0 } else { x }
}

/// Cosine of an angle in degrees, to 1e-14.
pub fn cosine(degrees: f64) -> f64 {
    let turns = degrees / 360.0;
    let x = (turns - (turns + 0.5).floor()) * (2.0 * std::f64::consts::PI);
    let (mut sum, mut term) = (1.0, 1.0);
    for n in 1..=15 {
        term = term * -x * x / f64::from((2 * n - 1) * (2 * n));
        sum += term;
    }
    sum
}

/// e^x for x up to 700, with a relative error of 1e-14; 0 below -700.
pub fn exponential(x: f64) -> f64 {
    if x < -700.0 {
        return 0.0;
    }
    let doublings = (x / std::f64::consts::LN_2 + 0.5).floor();
    let r = x - doublings * std::f64::consts::LN_2;
    let (mut sum, mut term) = (1.0, 1.0);
    for n in 1..=16 {
        term = term * r / f64::from(n);
        sum += term;
    }
    sum * f64::from_bits(((doublings as i64 + 1023) as u64) << 52)
}

/// Natural logarithm of a normal number, to 1e-15 of itself or of 1.
pub fn logarithm(x: f64) -> f64 {
    let exponent = ((x.to_bits() >> 52) & 0x7ff) as i32 - 1022;
    // In [1/2, 1).
    let mantissa = f64::from_bits(x.to_bits() & !(0x7ff << 52) | 1022 << 52);
    let (doublings, m) = if mantissa < std::f64::consts::FRAC_1_SQRT_2 {
        (exponent - 1, 2.0 * mantissa)
    } else {
        (exponent, mantissa)
    };
    // ln m = 2 artanh((m - 1) / (m + 1)), and that is below 0.172.
    let ratio = (m - 1.0) / (m + 1.0);
    let square = ratio * ratio;
    let (mut sum, mut power) = (0.0, ratio);
    for n in 0..12 {
        sum += power / f64::from(2 * n + 1);
        power *= square;
    }
    2.0 * sum + f64::from(doublings) * std::f64::consts::LN_2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_agree_with_the_standard_library() {
        for k in -20_000..=20_000 {
            let x = f64::from(k) * 0.034;
            assert!((exponential(x) / x.exp() - 1.0).abs() < 1e-13, "exp {x}");
            assert!((cosine(x) - x.to_radians().cos()).abs() < 1e-13, "cos {x}");
            let positive = (x.abs() + 1e-3) * 10_f64.powi(k / 200);
            let difference = logarithm(positive) - positive.ln();
            assert!(difference.abs() < 1e-15 * positive.ln().abs().max(1.0), "ln {positive}");
        }
    }
}
