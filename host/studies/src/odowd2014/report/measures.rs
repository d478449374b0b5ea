//! Measures and tests of runs: foraging rates, and fractions of what genes select.

use oneiro::foraging::Light;

pub(super) use crate::odowd2014::measures::{BIN, G0, G1, Gene, MINUTE, S0, minutes, per_minute, total};
use crate::odowd2014::results::{Case, Combination, Kind, RobotInterval, Run};
use oneiro_report::figures::Spread;
use oneiro_statistics::{cohens_d, mean, student_t, variance};

/// Number of final intervals that are averaged for the end of a run.
pub(super) const LAST: usize = 10;

/// The runs of a case and kind.
pub(super) fn runs_of(combination: &Combination, case: Case, kind: Kind) -> Vec<&Run> {
    combination.of(case, kind).collect()
}

/// Third of its range that a gene is in: opposite, no light or over; flees light, searches at random or seeks light.
pub(super) fn third(gene: f32) -> usize {
    third_of(Light::of_gene(gene))
}

/// Third in which a simulator has the light at `light`.
pub(super) fn third_of(light: Light) -> usize {
    match light {
        Light::OppositeNest => 0,
        Light::Nowhere => 1,
        Light::OverNest => 2,
    }
}

/// Fraction of some robots with a gene in each third; NaN if there are no robots.
pub(super) fn shares<'a>(robots: impl IntoIterator<Item = &'a RobotInterval>, gene: Gene) -> [f64; 3] {
    let mut counts = [0_u32; 3];
    for robot in robots {
        counts[third(gene(robot))] += 1;
    }
    let all = f64::from(counts.iter().sum::<u32>());
    counts.map(|count| f64::from(count) / all)
}

/// The robots of all runs in one interval.
pub(super) fn robots_at<'a>(runs: &'a [&Run], interval: usize) -> impl Iterator<Item = &'a RobotInterval> {
    runs.iter().filter_map(move |run| run.intervals.get(interval)).flatten()
}

/// Intervals of the longest run.
pub(super) fn intervals(runs: &[&Run]) -> usize {
    runs.iter().map(|run| run.intervals.len()).max().unwrap_or(0)
}

/// The robots of a run's final intervals.
pub(super) fn at_the_end(run: &Run) -> impl Iterator<Item = &RobotInterval> {
    let first = run.intervals.len().saturating_sub(LAST);
    run.intervals[first..].iter().flatten()
}

/// Mean and standard deviation of a gene; NaN if there are too few robots.
pub(super) fn level<'a>(robots: impl IntoIterator<Item = &'a RobotInterval>, gene: Gene) -> (f64, f64) {
    let genes: Vec<f64> = robots.into_iter().map(|robot| f64::from(gene(robot))).collect();
    (mean(&genes), variance(&genes).sqrt())
}

/// Mean of a gene in each interval over robots and runs, plus and minus the standard deviation within the gene's range.
pub(super) fn levels(runs: &[&Run], gene: Gene) -> Vec<Spread> {
    let at = |interval| {
        let (mean, deviation) = level(robots_at(runs, interval), gene);
        let deviation = if deviation.is_finite() { deviation } else { 0.0 };
        Spread {
            low: (mean - deviation).max(0.0),
            mean,
            high: (mean + deviation).min(f64::from(GREATEST)),
        }
    };
    (0..intervals(runs)).map(at).collect()
}

/// Maximum of a gene.
const GREATEST: f32 = 0.99;

/// A mean without a spread.
pub(super) fn alone(mean: f64) -> Spread {
    Spread {
        low: mean,
        mean,
        high: mean,
    }
}

/// Comparison of two samples: Cohen's d, and the p of Student's t test.
pub(super) struct Difference {
    pub(super) d: f64,
    pub(super) p: f64,
}

/// Compares the first sample with the second; NaN if they are too small or don't vary.
pub(super) fn difference(a: &[f64], b: &[f64]) -> Difference {
    Difference {
        d: cohens_d(a, b).unwrap_or(f64::NAN),
        p: student_t(a, b).map_or(f64::NAN, |test| test.p.value),
    }
}
