//! Samples of outcomes in figures.

use std::collections::BTreeMap;

use crate::report::figures::Spread;
use crate::statistics::{mean, quantile_of_sorted, t_within, variance};

/// The share of chances that a confidence interval stands for.
pub(super) const CONFIDENCE: f64 = 0.95;

/// The outcomes of some runs.
#[derive(Clone, Debug, Default)]
pub(super) struct Sample {
    /// Those that are numbers, in ascending order.
    pub(super) values: Vec<f64>,
    /// How many are not.
    pub(super) not_numbers: usize,
    /// The seeds of all these runs, in ascending order, each once.
    seeds: Vec<u64>,
}

impl Sample {
    /// Of seeds and outcomes.
    pub(super) fn new(runs: impl IntoIterator<Item = (u64, f64)>) -> Self {
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
        }
    }

    /// The arithmetic mean; NaN without values.
    pub(super) fn mean(&self) -> f64 {
        mean(&self.values)
    }

    /// The mean to rank samples by: below all others without values.
    pub(super) fn mean_or_least(&self) -> f64 {
        if self.values.is_empty() {
            f64::NEG_INFINITY
        } else {
            self.mean()
        }
    }

    /// The standard deviation with n - 1 below; NaN for fewer than two values.
    pub(super) fn deviation(&self) -> f64 {
        variance(&self.values).sqrt()
    }

    /// The least value, the quartiles and the greatest; NaN without values.
    pub(super) fn quartiles(&self) -> [f64; 5] {
        [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| quantile_of_sorted(&self.values, share))
    }

    /// The mean and its confidence interval.
    pub(super) fn spread(&self) -> Spread {
        let mut moments = Moments::default();
        for &value in &self.values {
            moments.add(value);
        }
        moments.spread(&mut Critical::default())
    }

    /// Seeds that both have.
    pub(super) fn shared_seeds(&self, other: &Self) -> usize {
        let has = |seed: &&u64| other.seeds.binary_search(seed).is_ok();
        self.seeds.iter().filter(has).count()
    }

    /// Whether both have the same seeds.
    pub(super) fn has_seeds_of(&self, other: &Self) -> bool {
        self.seeds == other.seeds
    }
}

/// What is kept of values that come one by one, by Welford's recurrence ("Note on a method for calculating corrected
/// sums of squares and products", Technometrics 4(3), 1962): sums of squares would lose what large values differ by.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moments {
    pub(super) count: u32,
    mean: f64,
    /// The sum of the squared differences from the mean.
    squares: f64,
}

impl Moments {
    /// One value more.
    pub(super) fn add(&mut self, value: f64) {
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / f64::from(self.count);
        self.squares += before * (value - self.mean);
    }

    /// The mean; NaN of nothing.
    pub(super) fn mean(&self) -> f64 {
        if self.count == 0 { f64::NAN } else { self.mean }
    }

    /// The mean and its confidence interval by Student's t; of one value that value alone, and NaN of none.
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

/// The t of confidence intervals by degrees of freedom: each takes long enough to be found only once.
#[derive(Debug, Default)]
pub(super) struct Critical(BTreeMap<u32, f64>);

impl Critical {
    fn t(&mut self, df: u32) -> f64 {
        *self.0.entry(df).or_insert_with(|| t_within(CONFIDENCE, f64::from(df)))
    }
}
