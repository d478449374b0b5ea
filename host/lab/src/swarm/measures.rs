//! Measures of a run.

use std::ops::Range;

use oneiro::foraging::Light;
use oneiro_statistics::{mean, roc_area, variance};

use super::record::{Case, RobotInterval, Run};

/// Seconds of a minute, and of a bin of Figure 5.
pub const MINUTE: usize = 60;
pub const BIN: usize = 250;
/// Selects a gene of a robot in an interval.
pub type Gene = fn(&RobotInterval) -> f32;
pub const S0: Gene = |own| own.s0;
pub const G0: Gene = |own| own.g0;
pub const G1: Gene = |own| own.g1;

impl Run {
    /// Food per minute that the swarm collected in a range of minutes; NaN if the run ended before.
    pub fn rate(&self, minutes: Range<usize>) -> f64 {
        let [start, end] = [minutes.start, minutes.end].map(|minute| (minute * MINUTE).min(self.brought.len()));
        per_minute(&self.brought[start..end])
    }

    /// Food per minute in successive bins of some seconds.
    pub fn rates(&self, bin: usize) -> Vec<f64> {
        self.brought.chunks(bin).map(per_minute).collect()
    }

    /// All robots in a range of intervals, as far as the run goes.
    pub fn robots(&self, intervals: Range<usize>) -> impl Iterator<Item = &RobotInterval> {
        self.intervals
            .iter()
            .skip(intervals.start)
            .take(intervals.len())
            .flatten()
    }

    /// Fraction of simulators that have the light at `light`.
    pub fn share(&self, light: Light, intervals: Range<usize>) -> f64 {
        let there = |own: &RobotInterval| if Light::of_gene(own.s0) == light { 1.0 } else { 0.0 };
        mean(self.robots(intervals).map(there))
    }

    /// The mean of a gene.
    pub fn mean(&self, gene: Gene, intervals: Range<usize>) -> f64 {
        mean(self.values(gene, intervals))
    }

    /// The standard deviation of a gene over robots and intervals.
    pub fn deviation(&self, gene: Gene, intervals: Range<usize>) -> f64 {
        variance(&self.values(gene, intervals)).sqrt()
    }

    /// The area under the curve of robots' real fitness for "the simulator that the gene stands for has the light where it
    /// is", over the intervals from the third to the last but one; none if all simulators or none are right. The light moves in
    /// the interval `moves`; `of` gives the gene by interval and robot.
    pub fn area(&self, moves: usize, of: impl Fn(usize, usize) -> f32) -> Option<f64> {
        let mut scores = Vec::new();
        let mut right = Vec::new();
        for interval in 2..self.intervals.len().saturating_sub(1) {
            let light = self.case.light_in(interval, moves);
            for (robot, own) in self.intervals[interval].iter().enumerate() {
                scores.push(f64::from(own.real));
                right.push(Light::of_gene(of(interval, robot)) == light);
            }
        }
        roc_area(&scores, &right).ok()
    }

    fn values(&self, gene: Gene, intervals: Range<usize>) -> Vec<f64> {
        self.robots(intervals).map(|own| f64::from(gene(own))).collect()
    }
}

/// Food per minute from the food of each second; NaN for an empty slice.
pub fn per_minute(brought: &[u16]) -> f64 {
    60.0 * total(brought) as f64 / brought.len() as f64
}

/// Total food.
pub fn total(brought: &[u16]) -> u64 {
    brought.iter().map(|&food| u64::from(food)).sum()
}

impl Case {
    /// Position of the light in an interval.
    pub fn light_in(self, interval: usize, moves: usize) -> Light {
        self.lights()[usize::from(interval >= moves)]
    }
}

#[cfg(test)]
mod tests {
    use super::super::record::Kind;
    use super::*;

    /// A run with two robots and two minutes: food at seconds 10, 70 and 71.
    fn run() -> Run {
        let own = |s0, g0| RobotInterval {
            s0,
            chosen_under: s0,
            g0,
            g1: 0.0,
            real: 0.0,
            simulated: None,
            heard: 0,
            reached: 1,
            taken: false,
            founder: 0,
        };
        let mut brought = vec![0; 120];
        brought[10] = 1;
        brought[70] = 1;
        brought[71] = 2;
        Run {
            case: Case::Over,
            kind: Kind::Evolved,
            number: 0,
            switched_on: vec![0; 2],
            brought,
            intervals: vec![vec![own(0.1, 0.2), own(0.5, 0.4)], vec![own(0.7, 0.6), own(0.99, 0.8)]],
        }
    }

    #[test]
    fn measures_are_those_worked_out_by_hand() {
        let run = run();
        assert_eq!((run.rate(0..1), run.rate(1..2), run.rate(0..2)), (1.0, 3.0, 2.0));
        assert_eq!(run.rates(MINUTE), [1.0, 3.0]);
        assert_eq!(run.rates(BIN), [2.0]);
        assert_eq!(run.share(Light::OppositeNest, 0..1), 0.5);
        assert_eq!(run.share(Light::OverNest, 0..2), 0.5);
        assert_eq!(run.share(Light::OverNest, 1..50), 1.0);
        assert!((run.mean(G0, 0..2) - 0.5).abs() < 1e-6);
        let deviation = ((0.09 + 0.01 + 0.01 + 0.09) / 3.0_f64).sqrt();
        assert!((run.deviation(G0, 0..2) - deviation).abs() < 1e-6);
        assert!(run.share(Light::OverNest, 2..3).is_nan());
    }

    #[test]
    fn the_light_moves_once() {
        assert_eq!(Case::OverThenOpposite.light_in(24, 25), Light::OverNest);
        assert_eq!(Case::OverThenOpposite.light_in(25, 25), Light::OppositeNest);
        assert_eq!(Case::Over.light_in(49, 25), Light::OverNest);
    }
}
