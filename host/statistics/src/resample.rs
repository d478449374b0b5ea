//! Resampling: intervals, and smaller samples out of larger ones.

use rand::Rng;

use super::summary::quantile_of_sorted;
use super::{Result, check, undefined};

/// An interval of a figure, both ends in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Its lower end.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

/// The bootstrap's percentile interval of a statistic of one or more samples, each resampled separately (Efron,
/// "Bootstrap methods: another look at the jackknife", Annals of Statistics 7(1), 1979). `level` is the fraction of the
/// resampled statistics that lie in it, such as 0.95. One generator's state gives one interval.
///
/// # Errors
///
/// An empty sample, no resample, a level that is not between 0 and 1, or a statistic that is not finite.
pub fn bootstrap_interval(
    samples: &[&[f64]],
    statistic: impl Fn(&[Vec<f64>]) -> f64,
    level: f64,
    resamples: usize,
    random: &mut (impl Rng + ?Sized),
) -> Result<Interval> {
    const FIGURE: &str = "bootstrap interval";
    check(FIGURE, samples, 1)?;
    if resamples == 0 {
        return undefined(FIGURE, "has 0 resamples; allowed: 1 or more");
    }
    if !(level > 0.0 && level < 1.0) {
        return undefined(FIGURE, format!("its level is {level}; allowed: between 0 and 1"));
    }
    let mut resampled: Vec<Vec<f64>> = samples.iter().map(|sample| sample.to_vec()).collect();
    let mut statistics = Vec::with_capacity(resamples);
    for _ in 0..resamples {
        for (resampled, sample) in resampled.iter_mut().zip(samples) {
            resampled.fill_with(|| sample[index(sample.len(), random)]);
        }
        statistics.push(statistic(&resampled));
    }
    if let Some(value) = statistics.iter().find(|value| !value.is_finite()) {
        return undefined(
            FIGURE,
            format!("the statistic of a resample is {value}; allowed: finite numbers"),
        );
    }
    let tail = (1.0 - level) / 2.0;
    statistics.sort_by(f64::total_cmp);
    Ok(Interval {
        low: quantile_of_sorted(&statistics, tail),
        high: quantile_of_sorted(&statistics, 1.0 - tail),
    })
}

/// The jackknife's pseudo-values of a statistic of `count` independent units, computed from the numbers of those that are kept. Their mean
/// and its interval are those of the statistic, without much bias (Tukey, "Bias and confidence in not-quite large samples", Annals of
/// Mathematical Statistics 29(2), 1958). A single unit has a single value, and so no interval.
pub fn pseudo_values(count: usize, statistic: impl Fn(&[usize]) -> f64) -> Vec<f64> {
    let all: Vec<usize> = (0..count).collect();
    let whole = statistic(&all);
    if count < 2 {
        return vec![whole; count];
    }
    let without = |left: &usize| {
        let kept: Vec<usize> = all.iter().copied().filter(|unit| unit != left).collect();
        count as f64 * whole - (count - 1) as f64 * statistic(&kept)
    };
    all.iter().map(without).collect()
}

/// Draws `size` different ones of the numbers below `count`, or all of them if there are fewer; each set has the same
/// chance. One generator's state gives one set.
pub fn subset(count: usize, size: usize, random: &mut (impl Rng + ?Sized)) -> Vec<usize> {
    let mut all: Vec<usize> = (0..count).collect();
    let size = size.min(count);
    // The first places of a shuffle.
    for place in 0..size {
        all.swap(place, place + index(count - place, random));
    }
    all.truncate(size);
    all
}

/// A number below `count`, by the upper half of a product: no chance is off by more than `count` / 2^64 of itself.
fn index(count: usize, random: &mut (impl Rng + ?Sized)) -> usize {
    ((u128::from(random.next_u64()) * count as u128) >> 64) as usize
}
