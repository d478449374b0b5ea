//! Samples of outcomes and their statistics.

use std::collections::BTreeMap;

use oneiro_report::figures::Spread;
use oneiro_statistics::{Interval, mean, median_interval, quantile_of_sorted, t_within, variance};

/// Confidence level of intervals.
pub(super) const CONFIDENCE: f64 = 0.95;

/// Outcomes of some runs.
#[derive(Clone, Debug, Default)]
pub(super) struct Sample {
    /// Outcomes that are numbers, in ascending order.
    pub(super) values: Vec<f64>,
    /// Number of outcomes that aren't.
    pub(super) not_numbers: usize,
    /// Distinct seeds of all these runs, in ascending order.
    seeds: Vec<u64>,
    /// Whether less is better.
    is_less_better: bool,
}

impl Sample {
    /// Makes a sample from seeds and outcomes, of which more or less is better.
    pub(super) fn new(runs: impl IntoIterator<Item = (u64, f64)>, is_less_better: bool) -> Self {
        let (mut seeds, mut values): (Vec<u64>, Vec<f64>) = runs.into_iter().unzip();
        let runs = values.len();
        values.retain(|value| value.is_finite());
        values.sort_by(f64::total_cmp);
        seeds.sort_unstable();
        seeds.dedup();
        Self {
            not_numbers: runs - values.len(),
            values,
            seeds,
            is_less_better,
        }
    }

    /// Arithmetic mean; NaN if there are no values.
    pub(super) fn mean(&self) -> f64 {
        mean(&self.values)
    }

    /// The better, the greater: by the mean. Samples without values come last.
    pub(super) fn merit(&self) -> f64 {
        match (self.values.is_empty(), self.is_less_better) {
            (true, _) => f64::NEG_INFINITY,
            (false, true) => -self.mean(),
            (false, false) => self.mean(),
        }
    }

    /// Whether less is better.
    pub(super) fn is_less_better(&self) -> bool {
        self.is_less_better
    }

    /// Standard deviation with divisor n - 1; NaN for fewer than two values.
    pub(super) fn deviation(&self) -> f64 {
        variance(&self.values).sqrt()
    }

    /// Minimum, quartiles and maximum; NaN if there are no values.
    pub(super) fn quartiles(&self) -> [f64; 5] {
        [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| quantile_of_sorted(&self.values, share))
    }

    /// Confidence interval of the median; `None` for fewer than six values.
    pub(super) fn median_interval(&self) -> Option<Interval> {
        median_interval(&self.values, CONFIDENCE).ok()
    }

    /// Mean with its confidence interval.
    pub(super) fn spread(&self) -> Spread {
        let mut moments = Moments::default();
        for &value in &self.values {
            moments.add(value);
        }
        moments.spread(&mut Critical::default())
    }

    /// Number of seeds in both samples.
    pub(super) fn shared_seeds(&self, other: &Self) -> usize {
        let has = |seed: &&u64| other.seeds.binary_search(seed).is_ok();
        self.seeds.iter().filter(has).count()
    }

    /// Whether both have the same seeds.
    pub(super) fn has_seeds_of(&self, other: &Self) -> bool {
        self.seeds == other.seeds
    }
}

/// Running moments by Welford's recurrence ("Note on a method for calculating corrected sums of squares and products",
/// Technometrics 4(3), 1962): sums of squares would cancel the differences between large values.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moments {
    pub(super) count: u32,
    mean: f64,
    /// Sum of squared differences from the mean.
    squares: f64,
}

impl Moments {
    /// Adds a value.
    pub(super) fn add(&mut self, value: f64) {
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / f64::from(self.count);
        self.squares += before * (value - self.mean);
    }

    /// Mean; NaN if there are no values.
    pub(super) fn mean(&self) -> f64 {
        if self.count == 0 { f64::NAN } else { self.mean }
    }

    /// Mean with its confidence interval by Student's t; the interval of a single value is that value. NaN if there are no
    /// values.
    pub(super) fn spread(&self, critical: &mut Critical) -> Spread {
        let Self { count, mean, squares } = *self;
        let n = f64::from(count);
        match count {
            0 => Spread {
                low: f64::NAN,
                mean: f64::NAN,
                high: f64::NAN,
            },
            1 => Spread {
                low: mean,
                mean,
                high: mean,
            },
            _ => {
                let reach = critical.t(count - 1) * (squares / (n - 1.0) / n).sqrt();
                Spread {
                    low: mean - reach,
                    mean,
                    high: mean + reach,
                }
            }
        }
    }
}

/// Critical values of t by degrees of freedom, cached because they are slow to compute.
#[derive(Debug, Default)]
pub(super) struct Critical(BTreeMap<u32, f64>);

impl Critical {
    fn t(&mut self, df: u32) -> f64 {
        *self.0.entry(df).or_insert_with(|| t_within(CONFIDENCE, f64::from(df)))
    }
}
