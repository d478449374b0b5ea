//! Tail probabilities of distributions, also as logarithms, so that none is too small to represent.
//!
//! `statrs` has the gamma function and its incomplete integral in the body of the distribution. In the tails it has no
//! logarithms: below 1e-308 it returns 0, and its incomplete beta function stops after 140 terms of its continued
//! fraction, whether or not these are enough. Here both fractions are evaluated in log space, until they converge. For
//! up to 100,000 degrees of freedom the relative error of a probability is below 1e-9.

use statrs::function::gamma::{gamma_lr, ln_gamma};

/// Probability of a statistic at least as extreme under the null hypothesis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probability {
    /// The p value, 0 to 1; 0 below the smallest positive number.
    pub value: f64,
    /// Its natural logarithm, finite also where the value is 0 for being small.
    pub ln: f64,
}

impl Probability {
    /// The probability of a logarithm; one above 0 counts as 0.
    pub(super) fn from_ln(ln: f64) -> Self {
        let ln = ln.min(0.0);
        Self { value: ln.exp(), ln }
    }

    /// A probability that is not small; one above 1 counts as 1.
    pub(super) fn new(value: f64) -> Self {
        Self::from_ln(value.ln())
    }

    /// Twice the probability, or 1.
    pub(super) fn twice(self) -> Self {
        Self::from_ln(self.ln + std::f64::consts::LN_2)
    }
}

/// P(F >= f) of Fisher's distribution; f at least 0, both degrees of freedom positive.
pub(crate) fn f_tail(f: f64, between: f64, within: f64) -> Probability {
    let total = within + between * f;
    beta_tail(within / 2.0, between / 2.0, within / total, between * f / total)
}

/// P(|T| >= |t|) of Student's distribution; the degrees of freedom are positive.
pub fn t_tails(t: f64, df: f64) -> Probability {
    f_tail(t * t, 1.0, df)
}

/// P(|Z| >= |z|) of the standard normal distribution.
pub(crate) fn normal_tails(z: f64) -> Probability {
    chi_squared_tail(z * z, 1.0)
}

/// P(X >= x) of the chi-squared distribution: Q(df / 2, x / 2); x at least 0, df positive.
pub fn chi_squared_tail(x: f64, df: f64) -> Probability {
    let (a, x) = (df / 2.0, x / 2.0);
    if x <= 0.0 {
        return Probability::from_ln(0.0);
    }
    if x < a + 1.0 {
        return Probability::from_ln((-gamma_lr(a, x)).ln_1p());
    }
    // DLMF 8.9.2, its even part: Q(a, x) = x^a e^-x / Gamma(a) / (x + 1 - a - 1 (1 - a) / (x + 3 - a - ...)).
    let fraction = continued_fraction(x + 1.0 - a, |n| (n * (a - n), x + 1.0 - a + 2.0 * n));
    Probability::from_ln(a * x.ln() - x - ln_gamma(a) - fraction.ln())
}

/// The regularised incomplete beta function `I_x(a, b)`, where x + y = 1.
///
/// Above the mean a / (a + b) it is taken from the other side: it is no less than about 0.3 there, so that the
/// difference to 1 loses nothing.
pub(super) fn beta_tail(a: f64, b: f64, x: f64, y: f64) -> Probability {
    if y * (a + b) < b {
        return Probability::from_ln((-ln_incomplete_beta(b, a, y, x).exp()).ln_1p());
    }
    Probability::from_ln(ln_incomplete_beta(a, b, x, y))
}

/// `ln I_x(a, b)` for x up to about the mean, where the fraction converges soon (DLMF 8.17.22).
fn ln_incomplete_beta(a: f64, b: f64, x: f64, y: f64) -> f64 {
    let fraction = continued_fraction(1.0, |term| {
        let half = (term / 2.0).floor();
        let numerator = if term % 2.0 == 0.0 {
            half * (b - half)
        } else {
            -(a + half) * (a + b + half)
        };
        (numerator * x / ((a + term - 1.0) * (a + term)), 1.0)
    });
    let ln_beta = ln_gamma(a) + ln_gamma(b) - ln_gamma(a + b);
    a * x.ln() + b * y.ln() - a.ln() - ln_beta - fraction.ln()
}

/// `first + a1 / (b1 + a2 / (b2 + ...))`, of which `term(n)` gives a and b, to the last place: Lentz's method as
/// modified by Thompson and Barnett ("Coulomb and Bessel functions of complex arguments and order", Journal of
/// Computational Physics 64(2), 1986).
fn continued_fraction(first: f64, term: impl Fn(f64) -> (f64, f64)) -> f64 {
    /// Stands for a denominator that is 0.
    const TINY: f64 = 1e-300;
    /// Far more than the square root of any count of degrees of freedom, which is about what convergence takes.
    const TERMS: u32 = 100_000;
    let nonzero = |x: f64| if x == 0.0 { TINY } else { x };
    let mut value = nonzero(first);
    let (mut c, mut d) = (value, 0.0);
    for n in 1..=TERMS {
        let (numerator, denominator) = term(f64::from(n));
        d = 1.0 / nonzero(denominator + numerator * d);
        c = nonzero(denominator + numerator / c);
        value *= c * d;
        if (c * d - 1.0).abs() <= f64::EPSILON {
            break;
        }
    }
    value
}
