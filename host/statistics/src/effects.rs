//! Sizes of effects. Those of two samples are positive where the first's values are the greater.

use super::ranks::rank;
use super::summary::{all_equal, mean, squares};
use super::{Result, check, undefined};

/// Cohen's d: the difference of means, first minus second, over the pooled standard deviation ("Statistical Power
/// Analysis for the Behavioral Sciences", 1988).
///
/// # Errors
///
/// A sample of fewer than 2 values, or no variation within either.
pub fn cohens_d(a: &[f64], b: &[f64]) -> Result<f64> {
    const FIGURE: &str = "Cohen's d";
    check(FIGURE, &[a, b], 2)?;
    if all_equal(&[a]) && all_equal(&[b]) {
        return undefined(
            FIGURE,
            "the deviation that it is divided by is 0; allowed: some variation",
        );
    }
    let variance = (squares(a) + squares(b)) / (a.len() + b.len() - 2) as f64;
    Ok((mean(a) - mean(b)) / variance.sqrt())
}

/// Vargha and Delaney's A: the chance that a value of the first sample is greater than one of the second, ties counted
/// half ("A critique and improvement of the CL common language effect size statistics of `McGraw` and Wong", Journal of
/// Educational and Behavioral Statistics 25(2), 2000).
///
/// # Errors
///
/// An empty sample.
pub fn vargha_delaney(a: &[f64], b: &[f64]) -> Result<f64> {
    superiority("Vargha and Delaney's A", a, b)
}

/// Cliff's delta: the chance that a value of the first sample is greater than one of the second, minus the chance that
/// it is less ("Dominance statistics: ordinal analyses to answer ordinal questions", Psychological Bulletin 114(3),
/// 1993); 2 A - 1.
///
/// # Errors
///
/// An empty sample.
pub fn cliffs_delta(a: &[f64], b: &[f64]) -> Result<f64> {
    Ok(2.0 * superiority("Cliff's delta", a, b)? - 1.0)
}

/// The area under the ROC curve of scores that are to be greater where `positive` holds: the chance that they are, for
/// one of either kind, ties counted half (Hanley and `McNeil`, "The meaning and use of the area under a receiver
/// operating characteristic curve", Radiology 143(1), 1982).
///
/// # Errors
///
/// Not one label for each score, or labels of one kind only.
pub fn roc_area(scores: &[f64], positive: &[bool]) -> Result<f64> {
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
