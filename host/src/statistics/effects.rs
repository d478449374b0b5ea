//! Sizes of effects. Those of two samples are positive where the first's values are the greater.

use statrs::function::gamma::ln_gamma;

use super::ranks::rank;
use super::summary::{all_equal, mean, squares, variance};
use super::{Result, check, undefined};

/// What a difference of means is divided by: a standard deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(test), expect(dead_code, reason = "claims state Cohen's d alone yet"))]
pub(crate) enum Divisor {
    /// Of both samples about their own means, by degrees of freedom (Cohen's d).
    Pooled,
    /// The root of the mean of the two variances, whatever the samples' sizes.
    Average,
    /// The first sample's.
    First,
    /// The second sample's (Glass's delta, where the second is the control).
    Second,
    /// Of all values about their common mean.
    Total,
}

/// The mean of the first sample minus that of the second, over a standard deviation.
///
/// # Errors
///
/// A sample of fewer than 2 values, or a deviation of 0.
pub(crate) fn standardised_difference(a: &[f64], b: &[f64], divisor: Divisor) -> Result<f64> {
    const FIGURE: &str = "standardised difference";
    check(FIGURE, &[a, b], 2)?;
    let constant = match divisor {
        Divisor::Pooled | Divisor::Average => all_equal(&[a]) && all_equal(&[b]),
        Divisor::First => all_equal(&[a]),
        Divisor::Second => all_equal(&[b]),
        Divisor::Total => all_equal(&[a, b]),
    };
    if constant {
        return undefined(
            FIGURE,
            "the deviation that it is divided by is 0; allowed: some variation",
        );
    }
    let variance = match divisor {
        Divisor::Pooled => (squares(a) + squares(b)) / (a.len() + b.len() - 2) as f64,
        Divisor::Average => f64::midpoint(variance(a), variance(b)),
        Divisor::First => variance(a),
        Divisor::Second => variance(b),
        Divisor::Total => variance(&[a, b].concat()),
    };
    Ok((mean(a) - mean(b)) / variance.sqrt())
}

/// Cohen's d: the difference of means over the pooled standard deviation ("Statistical Power Analysis for the
/// Behavioral Sciences", 1988).
///
/// # Errors
///
/// A sample of fewer than 2 values, or no variation within either.
pub(crate) fn cohens_d(a: &[f64], b: &[f64]) -> Result<f64> {
    standardised_difference(a, b, Divisor::Pooled)
}

/// Hedges's g: Cohen's d times the exact Γ(m / 2) / (sqrt(m / 2) Γ((m - 1) / 2)), m = N - 2, which makes it unbiased
/// ("Distribution theory for Glass's estimator of effect size and related estimators", Journal of Educational
/// Statistics 6(2), 1981).
///
/// # Errors
///
/// A sample of fewer than 2 values, or no variation within either.
#[cfg_attr(not(test), expect(dead_code, reason = "no claim states it yet"))]
pub(crate) fn hedges_g(a: &[f64], b: &[f64]) -> Result<f64> {
    let d = cohens_d(a, b)?;
    let half = (a.len() + b.len() - 2) as f64 / 2.0;
    Ok(d * (ln_gamma(half) - ln_gamma(half - 0.5)).exp() / half.sqrt())
}

/// Eta squared of an F and its degrees of freedom: the share of the sum of squares that is between groups.
pub(crate) fn eta_squared(f: f64, df_between: f64, df_within: f64) -> f64 {
    f * df_between / (f * df_between + df_within)
}

/// Vargha and Delaney's A: the chance that a value of the first sample is greater than one of the second, ties counted
/// half ("A critique and improvement of the CL common language effect size statistics of `McGraw` and Wong", Journal of
/// Educational and Behavioral Statistics 25(2), 2000).
///
/// # Errors
///
/// An empty sample.
pub(crate) fn vargha_delaney(a: &[f64], b: &[f64]) -> Result<f64> {
    superiority("Vargha and Delaney's A", a, b)
}

/// Cliff's delta: the chance that a value of the first sample is greater than one of the second, minus the chance that
/// it is less ("Dominance statistics: ordinal analyses to answer ordinal questions", Psychological Bulletin 114(3),
/// 1993); 2 A - 1.
///
/// # Errors
///
/// An empty sample.
pub(crate) fn cliffs_delta(a: &[f64], b: &[f64]) -> Result<f64> {
    Ok(2.0 * superiority("Cliff's delta", a, b)? - 1.0)
}

/// The area under the ROC curve of scores that are to be greater where `positive` holds: the chance that they are, for
/// one of either kind, ties counted half (Hanley and `McNeil`, "The meaning and use of the area under a receiver
/// operating characteristic curve", Radiology 143(1), 1982).
///
/// # Errors
///
/// Not one label for each score, or labels of one kind only.
pub(crate) fn roc_area(scores: &[f64], positive: &[bool]) -> Result<f64> {
    const FIGURE: &str = "area under the ROC curve";
    if scores.len() != positive.len() {
        return undefined(
            FIGURE,
            format!(
                "has {} labels of {} scores; allowed: one each",
                positive.len(),
                scores.len()
            ),
        );
    }
    let of_kind = |kind| {
        let labelled = scores.iter().zip(positive);
        labelled
            .filter(|(_, label)| **label == kind)
            .map(|(score, _)| *score)
            .collect::<Vec<_>>()
    };
    superiority(FIGURE, &of_kind(true), &of_kind(false))
}

/// U / (m n), from the sum of the first sample's ranks.
fn superiority(figure: &'static str, a: &[f64], b: &[f64]) -> Result<f64> {
    check(figure, &[a, b], 1)?;
    let (m, n) = (a.len() as f64, b.len() as f64);
    let sum: f64 = rank(&[a, b].concat()).ranks[..a.len()].iter().sum();
    Ok((sum - m * (m + 1.0) / 2.0) / (m * n))
}
