//! Tail probabilities of the tests of a race, made only of `+ - * /` and square roots, so that every host drops the
//! same candidates; those of [`oneiro_statistics`] are the platform's. Formulas: Abramowitz and Stegun, "Handbook of
//! Mathematical Functions" (1964), 7.1.6, 26.4.4, 26.4.5, 26.4.17, 26.7.3 and 26.7.4.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_2_PI, FRAC_2_SQRT_PI};

use oneiro::exact::{exponential, logarithm};

/// More degrees of freedom have the normal distribution of the cube root.
const MOST_SUMMED: usize = 600;

/// P(X >= x) of the chi-squared distribution with `df` degrees of freedom, 1 or more.
pub(super) fn chi_squared(x: f64, df: usize) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    if df > MOST_SUMMED {
        let variance = 2.0 / (9.0 * df as f64);
        let root = exponential(logarithm(x / df as f64) / 3.0);
        let z = (root - 1.0 + variance) / variance.sqrt();
        let tail = 0.5 * error_complement(z.abs() * FRAC_1_SQRT_2);
        return if z > 0.0 { tail } else { 1.0 - tail };
    }
    let y = 0.5 * x;
    let (mut sum, mut term, first) = if df.is_multiple_of(2) {
        (0.0, exponential(-y), 0.0)
    } else {
        (
            error_complement(y.sqrt()),
            exponential(-y) * y.sqrt() * FRAC_2_SQRT_PI,
            0.5,
        )
    };
    for k in 0..df / 2 {
        sum += term;
        term *= y / (k as f64 + 1.0 + first);
    }
    sum.min(1.0)
}

/// P(|T| >= t) of Student's distribution with `df` degrees of freedom, 1 or more; t is not negative.
pub(super) fn student(t: f64, df: usize) -> f64 {
    if t.is_infinite() {
        return 0.0;
    }
    let freedom = df as f64;
    let square = freedom / (freedom + t * t);
    let (cosine, sine) = (square.sqrt(), t / (freedom + t * t).sqrt());
    let is_odd = df % 2 == 1;
    let (mut term, mut n) = if is_odd { (cosine, 3.0) } else { (1.0, 2.0) };
    let mut sum = 0.0;
    for _ in 0..df / 2 {
        sum += term;
        term *= square * (n - 1.0) / n;
        n += 2.0;
    }
    let within = if is_odd {
        FRAC_2_PI * (arc_tangent(t / freedom.sqrt()) + sine * sum)
    } else {
        sine * sum
    };
    (1.0 - within).clamp(0.0, 1.0)
}

/// The complement of the error function, to 1e-13; 0 beyond 6. The argument is not negative.
fn error_complement(z: f64) -> f64 {
    if z > 6.0 {
        return 0.0;
    }
    let (mut sum, mut term) = (0.0, z);
    for n in 1..=200 {
        sum += term;
        term *= 2.0 * z * z / (2.0 * f64::from(n) + 1.0);
    }
    1.0 - FRAC_2_SQRT_PI * exponential(-z * z) * sum
}

/// The angle of a tangent that is not negative, halved three times before its series.
fn arc_tangent(tangent: f64) -> f64 {
    let mut x = tangent;
    for _ in 0..3 {
        x /= 1.0 + (1.0 + x * x).sqrt();
    }
    let square = x * x;
    let (mut sum, mut power) = (0.0, x);
    for n in 0..24 {
        sum += power / f64::from(2 * n + 1);
        power *= -square;
    }
    8.0 * sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use oneiro_statistics::{chi_squared_tail, t_tails};

    #[test]
    fn tails_are_those_of_the_statistics() {
        for df in [1, 2, 3, 4, 5, 10, 29, 100, 333, 600] {
            for share in [0.01, 0.1, 0.5, 0.8, 1.0, 1.3, 2.0, 4.0] {
                let x = share * f64::from(df);
                let expected = chi_squared_tail(x, df.into()).value;
                let found = chi_squared(x, df as usize);
                assert!((found - expected).abs() < 1e-11, "chi {df} {x}: {found} {expected}");
            }
            for t in [0.0, 0.1, 1.0, 1.96, 2.5, 10.0] {
                let expected = t_tails(t, df.into()).value;
                let found = student(t, df as usize);
                assert!((found - expected).abs() < 1e-11, "t {df} {t}: {found} {expected}");
            }
        }
        for (df, x) in [(601, 650.0), (2000, 1900.0), (2000, 2100.0)] {
            let expected = chi_squared_tail(x, f64::from(df)).value;
            assert!((chi_squared(x, df as usize) - expected).abs() < 1e-4, "{df} {x}");
        }
        assert_eq!(student(f64::INFINITY, 5), 0.0);
        assert_eq!(student(0.0, 5), 1.0);
    }
}
