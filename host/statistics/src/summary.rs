//! Figures of one sample. They are NaN where the sample has none.

use std::borrow::Borrow;

/// The arithmetic mean; NaN without values.
pub fn mean(values: impl IntoIterator<Item = impl Borrow<f64>>) -> f64 {
    let (sum, count) = values
        .into_iter()
        .fold((0.0, 0.0), |(sum, count), value| (sum + value.borrow(), count + 1.0));
    sum / count
}

/// The variance with n - 1 below; NaN for fewer than two values.
pub fn variance(sample: &[f64]) -> f64 {
    if sample.len() < 2 {
        return f64::NAN;
    }
    squares(sample) / (sample.len() - 1) as f64
}

/// The sum of the squared differences from the mean.
pub(super) fn squares(sample: &[f64]) -> f64 {
    let mean = mean(sample);
    sample.iter().map(|x| (x - mean) * (x - mean)).sum()
}

/// Whether all values of all samples are the same.
pub(super) fn all_equal(samples: &[&[f64]]) -> bool {
    let mut values = samples.iter().copied().flatten();
    values.next().is_none_or(|first| values.all(|value| value == first))
}

/// The middle value, or the mean of the middle two; NaN without values.
pub fn median(sample: &[f64]) -> f64 {
    quantile(sample, 0.5)
}

/// The value below which a fraction of the sample lies, 0 to 1: linear between the order statistics, the first at 0 and
/// the last at 1 (type 7 of Hyndman and Fan, "Sample quantiles in statistical packages", The American Statistician
/// 50(4), 1996). NaN without values, or for another fraction.
pub fn quantile(sample: &[f64], share: f64) -> f64 {
    let mut sorted = sample.to_vec();
    sorted.sort_by(f64::total_cmp);
    quantile_of_sorted(&sorted, share)
}

/// The same, of a sample in ascending order.
pub fn quantile_of_sorted(sorted: &[f64], share: f64) -> f64 {
    if sorted.is_empty() || !(0.0..=1.0).contains(&share) {
        return f64::NAN;
    }
    let position = share * (sorted.len() - 1) as f64;
    let below = sorted[position.floor() as usize];
    let above = sorted[position.ceil() as usize];
    below + (above - below) * position.fract()
}
