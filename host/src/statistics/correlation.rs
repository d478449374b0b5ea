//! Correlations of pairs.

use super::ranks::rank;
use super::special::{Probability, beta_tail};
use super::summary::{all_equal, mean, squares};
use super::{Result, check_pairs, undefined};

/// A correlation of pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Correlation {
    /// The coefficient, -1 to 1.
    pub(crate) r: f64,
    /// Degrees of freedom: pairs - 2.
    pub(crate) df: f64,
    /// Probability of a coefficient at least as far from 0, by Student's distribution; 0 for a perfect correlation,
    /// whose logarithm is minus infinity.
    pub(crate) p: Probability,
}

/// Pearson's correlation: of a straight line.
///
/// # Errors
///
/// Samples of two lengths, fewer than 3 pairs, or all values of a sample equal.
pub(crate) fn pearson(x: &[f64], y: &[f64]) -> Result<Correlation> {
    correlation("Pearson's correlation", x, y)
}

/// Spearman's correlation: Pearson's, of ranks.
///
/// # Errors
///
/// Samples of two lengths, fewer than 3 pairs, or all values of a sample equal.
pub(crate) fn spearman(x: &[f64], y: &[f64]) -> Result<Correlation> {
    const FIGURE: &str = "Spearman's correlation";
    check_pairs(FIGURE, x, y, 3)?;
    correlation(FIGURE, &rank(x).ranks, &rank(y).ranks)
}

fn correlation(figure: &'static str, x: &[f64], y: &[f64]) -> Result<Correlation> {
    check_pairs(figure, x, y, 3)?;
    if all_equal(&[x]) || all_equal(&[y]) {
        return undefined(figure, "all values of a sample are equal; allowed: some variation");
    }
    let (mean_x, mean_y) = (mean(x), mean(y));
    let products: f64 = x.iter().zip(y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let r = (products / (squares(x) * squares(y)).sqrt()).clamp(-1.0, 1.0);
    let df = (x.len() - 2) as f64;
    // t^2 = r^2 df / (1 - r^2), put into the beta function of Student's distribution.
    let p = beta_tail(df / 2.0, 0.5, (1.0 - r) * (1.0 + r), r * r);
    Ok(Correlation { r, df, p })
}
