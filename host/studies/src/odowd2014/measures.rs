//! Measures of runs for claims and reports.

use std::ops::Range;

use oneiro::foraging::Light;
pub(crate) use oneiro_lab::swarm::measures::{BIN, G0, G1, Gene, MINUTE, S0, per_minute, total};
use oneiro_lab::swarm::record::Run;
use oneiro_statistics::mean;

/// Phases that the claims name, in intervals of a minute; the light moves at 25.
pub(crate) const ALL: Range<usize> = 0..50;
pub(crate) const SETTLED: Range<usize> = 10..50;
pub(crate) const FIRST_HALF: Range<usize> = 0..25;
pub(crate) const SECOND_HALF: Range<usize> = 25..50;
pub(crate) const BEFORE_MOVE: Range<usize> = 15..25;
pub(crate) const LATE: Range<usize> = 40..50;

/// Food in each minute, as the mean over runs: the samples of the paper's test.
pub(crate) fn minutes<'a>(runs: impl Iterator<Item = &'a Run>) -> Vec<f64> {
    let rows: Vec<Vec<f64>> = runs.map(|run| run.rates(MINUTE)).collect();
    let length = rows.iter().map(Vec::len).min().unwrap_or(0);
    (0..length)
        .map(|minute| mean(rows.iter().map(|row| row[minute])))
        .collect()
}

/// Intervals that a fraction is averaged over.
const TOGETHER: usize = 5;

/// First interval from which more than half of the simulators have the light over the nest, as the mean over runs and
/// five intervals.
pub(super) fn convergence_interval(runs: &[Run]) -> Option<usize> {
    let intervals = runs.iter().map(|run| run.intervals.len()).min()?;
    let share = |first: usize| {
        let shares: Vec<f64> = runs
            .iter()
            .map(|run| run.share(Light::OverNest, first..first + TOGETHER))
            .collect();
        mean(&shares)
    };
    let below = (0..(intervals + 1).saturating_sub(TOGETHER))
        .rev()
        .find(|&first| share(first) <= 0.5);
    let first = below.map_or(0, |last| last + 1);
    (first + TOGETHER <= intervals).then_some(first)
}
