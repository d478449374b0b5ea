//! Many tests at once.

use super::{Result, undefined};

/// Holm's adjusted p values, in the order given: with these, each at most some level, the chance of one or more wrong
/// rejections is at most that level ("A simple sequentially rejective multiple test procedure", Scandinavian Journal of
/// Statistics 6(2), 1979). The i-th smallest of m, counted from 0, is multiplied by m - i, and is no less than the one
/// before and no more than 1.
///
/// # Errors
///
/// A value that is not between 0 and 1.
pub fn holm(p: &[f64]) -> Result<Vec<f64>> {
    if let Some(value) = p.iter().find(|value| !(0.0..=1.0).contains(*value)) {
        return undefined("Holm's correction", format!("a p value is {value}; allowed: 0 to 1"));
    }
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&i, &j| p[i].total_cmp(&p[j]));
    let mut adjusted = vec![0.0; p.len()];
    let mut greatest = 0.0_f64;
    for (rank, index) in order.into_iter().enumerate() {
        greatest = greatest.max((p.len() - rank) as f64 * p[index]).min(1.0);
        adjusted[index] = greatest;
    }
    Ok(adjusted)
}
