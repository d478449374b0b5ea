//! Readings by how far a robot has turned, and what repeats in them.

use super::{Overlap, Turned};

/// Samples of a turn on which readings are compared: half a degree.
const STEPS: f64 = 720.0;
/// A sensor whose readings differ by less than this, of 1023, shows no pattern.
const LEAST_CONTRAST: f64 = 50.0;

/// Readings of all sensors by angle, in turns, in order of time. The angle hardly ever falls.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Signal(Vec<(f64, Vec<u16>)>);

impl Signal {
    pub(super) fn push(&mut self, angle: f64, readings: Vec<u16>) {
        self.0.push((angle, readings));
    }

    /// The last angle.
    pub(super) fn end(&self) -> f64 {
        self.0.last().map_or(0.0, |(angle, _)| *angle)
    }

    /// The same by angles that are this many times smaller.
    pub(super) fn scaled(&self, apparent: f64) -> Self {
        let scaled = |(angle, readings): &(f64, Vec<u16>)| (angle / apparent, readings.clone());
        Self(self.0.iter().map(scaled).collect())
    }

    /// Readings from one angle to before another, as bearings.
    pub(super) fn turned(&self, from: f64, to: f64) -> Vec<Turned> {
        let within = self.0.iter().filter(|(angle, _)| (from..to).contains(&angle.max(0.0)));
        within
            .map(|(angle, readings)| Turned {
                bearing: angle.max(0.0).fract(),
                readings: readings.clone(),
            })
            .collect()
    }

    /// Readings interpolated at equal steps of the angle, from 0.
    fn steps(&self) -> Vec<Vec<f64>> {
        let Some((_, first)) = self.0.first() else {
            return Vec::new();
        };
        let numbers = |readings: &[u16]| readings.iter().copied().map(f64::from).collect::<Vec<_>>();
        let (mut steps, mut last) = (Vec::new(), (0.0, numbers(first)));
        for (angle, readings) in &self.0 {
            let next = (*angle, numbers(readings));
            while steps.len() as f64 / STEPS <= next.0 {
                let share = (steps.len() as f64 / STEPS - last.0) / (next.0 - last.0).max(1e-9);
                let between = last
                    .1
                    .iter()
                    .zip(&next.1)
                    .map(|(from, to)| from + share.min(1.0) * (to - from));
                steps.push(between.collect());
            }
            if next.0 >= last.0 {
                last = next;
            }
        }
        steps
    }

    /// Turns by the angle after which the readings repeat, from 0.85 to 1.18; none if they do not.
    pub(super) fn period(&self) -> Option<f64> {
        const PERIODS: [f64; 2] = [0.85, 1.18];
        /// Maximum variance between readings a period apart, as a fraction of that between readings at any two angles.
        const LIKE: f64 = 0.25;
        let steps = Steps(self.steps());
        let window = at(0.0)..at(0.8);
        if !steps.has_pattern(window.clone()) {
            return None;
        }
        let [least, most] = PERIODS.map(at);
        let (period, off) = steps.best(window.clone(), least..=most)?;
        if off > LIKE * steps.variance(window.clone()) {
            return None;
        }
        // Two periods measure it twice as precisely.
        let near = at(2.0 * period);
        let margin = at(0.02);
        let (double, _) = steps.best(window, near - margin..=near + margin)?;
        Some(0.5 * double)
    }

    /// How readings after whole turns agree with those at the beginning, over `length` turns minus `most`, the maximum error of
    /// the turns.
    pub(super) fn overlap(&self, turns: u32, length: f64, most: f64) -> Overlap {
        let steps = Steps(self.steps());
        let window = 0..at(length - most);
        let whole = at(f64::from(turns));
        if !steps.has_pattern(window.clone()) {
            return Overlap::Blank;
        }
        let Some((shift, off)) = steps.best(window.clone(), whole - at(most)..=whole + at(most)) else {
            return Overlap::Unlike;
        };
        if off > steps.variance(window.clone()) {
            return Overlap::Unlike;
        }
        Overlap::Late {
            drift: shift - f64::from(turns),
            difference: steps.difference(window, at(shift)),
        }
    }
}

/// The step at an angle.
fn at(angle: f64) -> usize {
    (angle * STEPS).round() as usize
}

/// Readings at steps of the angle.
struct Steps(Vec<Vec<f64>>);

impl Steps {
    /// Whether a sensor's readings differ enough there to be recognised.
    fn has_pattern(&self, window: std::ops::Range<usize>) -> bool {
        let within = || self.0.get(window.clone()).unwrap_or_default().iter();
        let sensors = self.0.first().map_or(0, Vec::len);
        (0..sensors).any(|sensor| {
            let readings = || within().map(|readings| readings[sensor]);
            let (low, high) = (readings().fold(f64::MAX, f64::min), readings().fold(f64::MIN, f64::max));
            high - low >= LEAST_CONTRAST
        })
    }

    /// Mean square difference between the readings of a window and those a shift later, summed over sensors.
    fn off(&self, window: std::ops::Range<usize>, shift: usize) -> Option<f64> {
        let later = self.0.get(window.start + shift..window.end + shift)?;
        let apart = |(one, other): (&Vec<f64>, &Vec<f64>)| -> f64 {
            one.iter()
                .zip(other)
                .map(|(one, other)| (one - other) * (one - other))
                .sum()
        };
        let count = later.len().max(1) as f64;
        Some(self.0[window].iter().zip(later).map(apart).sum::<f64>() / count)
    }

    /// Twice the variance of readings there, summed over sensors: the mean square difference between readings at any two angles.
    fn variance(&self, window: std::ops::Range<usize>) -> f64 {
        let within = &self.0[window];
        let count = within.len().max(1) as f64;
        let sensors = within.first().map_or(0, Vec::len);
        let of = |sensor: usize| {
            let mean = within.iter().map(|readings| readings[sensor]).sum::<f64>() / count;
            within
                .iter()
                .map(|readings| (readings[sensor] - mean).powi(2))
                .sum::<f64>()
                / count
        };
        2.0 * (0..sensors).map(of).sum::<f64>()
    }

    /// The shift, in turns, after which readings agree best, and their difference then. None if it is at an end of the shifts.
    fn best(&self, window: std::ops::Range<usize>, shifts: std::ops::RangeInclusive<usize>) -> Option<(f64, f64)> {
        let first = *shifts.start();
        let off: Vec<f64> = shifts.map_while(|shift| self.off(window.clone(), shift)).collect();
        let (best, least) = off
            .iter()
            .copied()
            .enumerate()
            .min_by(|(_, one), (_, other)| one.total_cmp(other))?;
        let (before, after) = (*off.get(best.checked_sub(1)?)?, *off.get(best + 1)?);
        // The vertex of the parabola through three points.
        let bend = before - 2.0 * least + after;
        let part = if bend > 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
        Some((((first + best) as f64 + part) / STEPS, least))
    }

    /// Mean difference between the readings of a window and those a shift later, of the sensor with the largest.
    fn difference(&self, window: std::ops::Range<usize>, shift: usize) -> f64 {
        let Some(later) = self.0.get(window.start + shift..window.end + shift) else {
            return 0.0;
        };
        let sensors = later.first().map_or(0, Vec::len);
        let of = |sensor: usize| {
            let pairs = self.0[window.clone()].iter().zip(later);
            pairs
                .map(|(one, other)| (one[sensor] - other[sensor]).abs())
                .sum::<f64>()
                / later.len().max(1) as f64
        };
        (0..sensors).map(of).fold(0.0, f64::max)
    }
}
