//! Differences between levels and between cells: effect sizes with intervals, and tests corrected for multiplicity.

use std::collections::BTreeMap;

use oneiro_statistics::{
    Interval, Method, bootstrap_interval, cliffs_delta, holm, kruskal_wallis, mann_whitney, vargha_delaney,
};
use rand_pcg::Pcg64;

use super::cells::Cells;
use super::runs::Runs;
use super::sample::{CONFIDENCE, Sample};

/// Minimum number of runs for a sample to be tested.
pub(super) const LEAST: usize = 3;
/// Maximum number of samples whose pairs are all compared; if there are more, each is compared only with the best.
pub(super) const FEW: usize = 12;
/// Maximum number of runs per sample for exact tests, if there are no ties.
pub(super) const EXACT: usize = 20;
/// Resamples of a bootstrap, and size of a sample that needs fewer of them.
pub(super) const RESAMPLES: usize = 1000;
pub(super) const FEWER_RESAMPLES: usize = 200;
/// Approximate number of values that a bootstrap draws; beyond that it has fewer resamples.
const DRAWS: usize = 2_000_000;
/// p below which a difference is highlighted.
pub(super) const LEVEL: f64 = 0.05;

/// All comparisons.
pub(super) struct Effects {
    /// Effect of each factor with several groups of levels.
    pub(super) factors: Vec<FactorEffect>,
    /// Pairs of a factor's groups, the later one first; if there are many, the best with each other one.
    pub(super) levels: Family,
    /// Pairs of cells, the better one first; if there are many, the best with each other one.
    pub(super) cells: Family,
    /// Similarity of runs with the same seed in two cells: the mean product of their deviations from their cells'
    /// means, over the mean square deviation. `None` if no two cells share a seed, or nothing varies within any.
    pub(super) seed_correlation: Option<f64>,
}

/// Tests that are corrected together.
#[derive(Default)]
pub(super) struct Family {
    pub(super) comparisons: Vec<Comparison>,
    /// Number of samples with too few runs to be tested.
    pub(super) untested: usize,
}

/// Comparison of two samples.
pub(super) struct Comparison {
    /// Factor that the groups belong to; `None` for cells.
    pub(super) factor: Option<usize>,
    /// The two samples: groups of the factor, or cells by rank, from 0.
    pub(super) pair: [usize; 2],
    pub(super) runs: [usize; 2],
    pub(super) means: [f64; 2],
    /// Vargha and Delaney's A and Cliff's delta of the first over the second.
    pub(super) a: f64,
    pub(super) delta: f64,
    /// Interval of delta.
    pub(super) interval: Option<Interval>,
    /// Mann and Whitney's U of the first, its p, whether that is exact, and p corrected for the family.
    pub(super) u: f64,
    pub(super) p: f64,
    is_exact: bool,
    pub(super) p_holm: f64,
    /// Number of seeds in both samples, and whether these are all.
    pub(super) shared_seeds: usize,
    pub(super) same_seeds: bool,
}

/// Variance explained by a factor.
pub(super) struct FactorEffect {
    pub(super) factor: usize,
    /// Fraction of the ranks' variance that is between groups, 0 to 1; NaN if unknown.
    pub(super) explained: f64,
    /// Test for more than two groups.
    pub(super) test: Option<OmnibusTest>,
}

/// Kruskal and Wallis's test.
pub(super) struct OmnibusTest {
    pub(super) h: f64,
    pub(super) df: f64,
    pub(super) p: f64,
    pub(super) p_holm: f64,
}

impl Effects {
    /// Compares groups of all factors that are [not tested as another](Runs::tested_as), and cells in order of rank.
    pub(super) fn of(runs: &Runs, samples: &[Vec<Sample>], cells: &Cells<'_>) -> Self {
        let mut factors: Vec<FactorEffect> = Vec::new();
        let mut levels = Family::default();
        for (factor, samples) in samples.iter().enumerate().filter(|(_, samples)| samples.len() > 1) {
            if runs.tested_as(factor).is_some() {
                continue;
            }
            factors.push(explained(factor, samples));
            let mut tested = levels.tested(samples.iter().enumerate());
            if tested.len() <= FEW {
                tested.reverse();
            } else {
                tested.sort_by(|(_, a), (_, b)| b.merit().total_cmp(&a.merit()));
            }
            levels.compare_all(Some(factor), &tested);
        }
        let mut of_cells = Family::default();
        if cells.ranked.len() > 1 {
            let tested = of_cells.tested(cells.ranked.iter().map(|cell| &cell.sample).enumerate());
            of_cells.compare_all(None, &tested);
        }
        levels.correct();
        of_cells.correct();
        correct(factors.iter_mut().filter_map(|factor| factor.test.as_mut()), |test| {
            (test.p, &mut test.p_holm)
        });
        Self {
            factors,
            levels,
            cells: of_cells,
            seed_correlation: seed_correlation(runs, cells),
        }
    }

    /// The comparison of two groups of a factor, if they were tested.
    pub(super) fn of_groups(&self, factor: usize, pair: [usize; 2]) -> Option<&Comparison> {
        let turned = [pair[1], pair[0]];
        let mut all = self.levels.comparisons.iter();
        all.find(|one| one.factor == Some(factor) && (one.pair == pair || one.pair == turned))
    }
}

impl Family {
    /// Samples that are large enough, with their indices; counts the others.
    fn tested<'a>(&mut self, samples: impl Iterator<Item = (usize, &'a Sample)>) -> Vec<(usize, &'a Sample)> {
        let (tested, others): (Vec<_>, Vec<_>) = samples.partition(|(_, sample)| sample.values.len() >= LEAST);
        self.untested += others.len();
        tested
    }

    /// Compares each sample with all that follow; if there are many, only the first.
    fn compare_all(&mut self, factor: Option<usize>, samples: &[(usize, &Sample)]) {
        let firsts = if samples.len() <= FEW { samples.len() } else { 1 };
        for (place, first) in samples[..firsts].iter().enumerate() {
            for second in &samples[place + 1..] {
                self.compare(factor, *first, *second);
            }
        }
    }

    /// Compares two samples, given with their indices.
    fn compare(&mut self, factor: Option<usize>, first: (usize, &Sample), second: (usize, &Sample)) {
        let (pair, [first, second]) = ([first.0, second.0], [first.1, second.1]);
        let (a, b) = (first.values.as_slice(), second.values.as_slice());
        let test = test(a, b);
        // Each comparison has a separate random stream, so it doesn't depend on the comparisons before.
        let stream = factor.map_or(0, |factor| factor as u128 + 1);
        let mut random = Pcg64::new((pair[0] as u128) << 64 | pair[1] as u128, stream);
        self.comparisons.push(Comparison {
            factor,
            pair,
            runs: [a.len(), b.len()],
            means: [first.mean(), second.mean()],
            a: vargha_delaney(a, b).unwrap_or(f64::NAN),
            delta: cliffs_delta(a, b).unwrap_or(f64::NAN),
            interval: delta_interval(a, b, &mut random),
            u: test.u,
            p: test.p,
            is_exact: test.is_exact,
            p_holm: f64::NAN,
            shared_seeds: first.shared_seeds(second),
            same_seeds: first.has_seeds_of(second),
        });
    }

    fn correct(&mut self) {
        correct(self.comparisons.iter_mut(), |one| (one.p, &mut one.p_holm));
    }

    /// Smallest corrected p that samples of these sizes can reach, which is that of two samples without overlap; 0 if unknown
    /// because not all tests are exact.
    pub(super) fn least_p(&self) -> f64 {
        let least = self.comparisons.iter().map(|one| {
            let [m, n] = one.runs;
            let orders = (1..=m).fold(1.0, |orders, i| orders * (n + i) as f64 / i as f64);
            if one.is_exact { 2.0 / orders } else { 0.0 }
        });
        (self.comparisons.len() as f64 * least.fold(1.0, f64::min)).min(1.0)
    }
}

/// See [`Effects::seed_correlation`].
fn seed_correlation(runs: &Runs, cells: &Cells<'_>) -> Option<f64> {
    // Count, sum and sum of squares of each seed's deviations from the means of cells.
    let mut seeds: BTreeMap<u64, [f64; 3]> = BTreeMap::new();
    for ranked in cells.ranked.iter().filter(|ranked| ranked.sample.values.len() >= LEAST) {
        let mean = ranked.sample.mean();
        for run in ranked.cell.runs.iter().map(|&run| &runs.all[run]) {
            if run.outcome.is_finite() {
                let difference = run.outcome - mean;
                let [count, sum, squares] = seeds.entry(run.seed).or_default();
                *count += 1.0;
                *sum += difference;
                *squares += difference * difference;
            }
        }
    }
    let (mut products, mut squares) = (0.0, 0.0);
    for [count, sum, square] in seeds.into_values() {
        products += sum * sum - square;
        squares += (count - 1.0) * square;
    }
    (squares > 0.0).then_some(products / squares)
}

/// Applies Holm's correction to all p values.
fn correct<'a, T: 'a>(tests: impl Iterator<Item = &'a mut T>, p: impl Fn(&'a mut T) -> (f64, &'a mut f64)) {
    let (raw, places): (Vec<f64>, Vec<&mut f64>) = tests.map(p).unzip();
    // All of them are probabilities, so the correction can't fail.
    for (place, corrected) in places.into_iter().zip(holm(&raw).unwrap_or_default()) {
        *place = corrected;
    }
}

/// Result of Mann and Whitney's test.
struct RankTest {
    u: f64,
    p: f64,
    is_exact: bool,
}

/// Mann and Whitney's test, exact for small samples without ties. If all values are equal, there is no evidence of a
/// difference.
fn test(a: &[f64], b: &[f64]) -> RankTest {
    let by = |method, is_exact| {
        let test = mann_whitney(a, b, method).ok()?;
        let (u, p) = (test.u, test.p.value);
        Some(RankTest { u, p, is_exact })
    };
    let is_small = a.len() <= EXACT && b.len() <= EXACT;
    let exact = is_small.then(|| by(Method::Exact, true)).flatten();
    exact.or_else(|| by(Method::Asymptotic, false)).unwrap_or(RankTest {
        u: (a.len() * b.len()) as f64 / 2.0,
        p: 1.0,
        is_exact: false,
    })
}

/// Bootstrap interval of Cliff's delta.
fn delta_interval(a: &[f64], b: &[f64], random: &mut Pcg64) -> Option<Interval> {
    let ends = |sample: &[f64]| Some((*sample.first()?, *sample.last()?));
    let ((least_a, most_a), (least_b, most_b)) = (ends(a)?, ends(b)?);
    // Resamples of samples without overlap don't overlap either.
    if least_a > most_b || least_b > most_a {
        let delta = if least_a > most_b { 1.0 } else { -1.0 };
        return Some(Interval {
            low: delta,
            high: delta,
        });
    }
    // Only the order of values matters: with their ranks, a resample is counted instead of sorted.
    let mut order = [a, b].concat();
    order.sort_by(f64::total_cmp);
    order.dedup();
    let places = |sample: &[f64]| -> Vec<f64> {
        let place = |x: &f64| order.partition_point(|y| y < x) as f64;
        sample.iter().map(place).collect()
    };
    let delta = |resampled: &[Vec<f64>]| {
        let mut counts = vec![[0_i64; 2]; order.len()];
        for (side, sample) in resampled.iter().enumerate() {
            for &place in sample {
                counts[place as usize][side] += 1;
            }
        }
        let (mut below, mut balance) = ([0, 0], 0);
        for [of_a, of_b] in counts {
            balance += of_a * below[1] - of_b * below[0];
            below = [below[0] + of_a, below[1] + of_b];
        }
        balance as f64 / (a.len() * b.len()) as f64
    };
    let resamples = (DRAWS / (a.len() + b.len())).clamp(FEWER_RESAMPLES, RESAMPLES);
    bootstrap_interval(&[&places(a), &places(b)], delta, CONFIDENCE, resamples, random).ok()
}

/// Variance explained by a factor, from its groups that are large enough.
fn explained(factor: usize, samples: &[Sample]) -> FactorEffect {
    let tested: Vec<&[f64]> = samples
        .iter()
        .map(|sample| sample.values.as_slice())
        .filter(|values| values.len() >= LEAST)
        .collect();
    let runs: usize = tested.iter().map(|values| values.len()).sum();
    let found = kruskal_wallis(&tested).ok();
    FactorEffect {
        factor,
        explained: found.map_or(f64::NAN, |test| test.h / (runs as f64 - 1.0)),
        test: found.filter(|_| tested.len() > 2).map(|test| OmnibusTest {
            h: test.h,
            df: test.df,
            p: test.p.value,
            p_holm: f64::NAN,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counted_resamples_are_sorted_ones() {
        let a = [1.0, 2.0, 2.0, 5.0, 7.5, 8.0];
        let b = [-3.0, 0.5, 2.0, 5.0];
        let counted = delta_interval(&a, &b, &mut Pcg64::new(7, 1)).expect("an interval");
        let sorted = |resampled: &[Vec<f64>]| cliffs_delta(&resampled[0], &resampled[1]).unwrap_or(f64::NAN);
        let sorted = bootstrap_interval(&[&a, &b], sorted, CONFIDENCE, RESAMPLES, &mut Pcg64::new(7, 1));
        let sorted = sorted.expect("an interval");
        assert!((counted.low - sorted.low).abs() < 1e-12 && (counted.high - sorted.high).abs() < 1e-12);
    }
}
