//! Moves: how far each wheel travels for a command, and how late.

use oneiro_statistics::{mean, variance};

use super::{Logged, half_width};

/// Measured behaviour of the wheels.
#[derive(Clone, Debug, PartialEq)]
pub struct Moves {
    /// Measured speed of each wheel as a fraction of the commanded one.
    pub gains: [f64; 2],
    /// Time from a command to its effect, s.
    pub latency: f64,
    /// Standard deviation of each wheel's travel in a cycle around gain times command, mm.
    pub deviation: [f64; 2],
    /// Standard deviation of a moving wheel's travel, as a fraction of the expected travel.
    pub relative: f64,
    /// Number of cycles with a wheel that moves.
    pub moving: usize,
}

/// Maximum latency that is tried, and the step between two, s.
const LATENCIES: (f64, f64) = (0.5, 0.005);
/// Minimum expected travel of a wheel in a cycle that counts as moving, mm: roundings of odometers are far below.
const LEAST_WAY: f64 = 1.0;
/// Difference of a gain from 1 above which motors should be sampled again.
const FAR_OFF: f64 = 0.03;

/// Commanded and measured travel of each wheel in each cycle, mm.
struct Ways {
    commanded: [Vec<f64>; 2],
    travelled: [Vec<f64>; 2],
}

impl Ways {
    fn of(lives: &[Logged], latency: f64) -> Self {
        let mut ways = Self {
            commanded: [Vec::new(), Vec::new()],
            travelled: [Vec::new(), Vec::new()],
        };
        for life in lives {
            for (index, pair) in life.cycles.windows(2).enumerate() {
                let [Some(before), Some(after)] = [pair[0].travel, pair[1].travel] else {
                    continue;
                };
                for wheel in 0..2 {
                    let commanded = commanded(life, wheel, index, [pair[0].time - latency, pair[1].time - latency]);
                    ways.commanded[wheel].push(commanded);
                    ways.travelled[wheel].push(after[wheel] - before[wheel]);
                }
            }
        }
        ways
    }

    /// The gain of a wheel by least squares; NaN if it was never commanded to move.
    fn gain(&self, wheel: usize) -> f64 {
        let (commanded, travelled) = (&self.commanded[wheel], &self.travelled[wheel]);
        let both: f64 = commanded
            .iter()
            .zip(travelled)
            .map(|(commanded, travelled)| commanded * travelled)
            .sum();
        both / commanded.iter().map(|commanded| commanded * commanded).sum::<f64>()
    }

    /// Differences from gain times command, mm.
    fn errors(&self, wheel: usize) -> Vec<f64> {
        let gain = self.gain(wheel);
        let pairs = self.commanded[wheel].iter().zip(&self.travelled[wheel]);
        pairs
            .map(|(commanded, travelled)| travelled - gain * commanded)
            .collect()
    }

    fn squares(&self) -> f64 {
        (0..2)
            .flat_map(|wheel| self.errors(wheel))
            .map(|error| error * error)
            .sum()
    }
}

/// Commanded travel of a wheel between two times, mm; `near` is the cycle of the later one, or one after it.
fn commanded(life: &Logged, wheel: usize, near: usize, [from, to]: [f64; 2]) -> f64 {
    let mut way = 0.0;
    let mut end = to;
    for cycle in life.cycles[..=near].iter().rev() {
        let begin = cycle.time.max(from);
        if begin < end {
            way += cycle.commanded[wheel] * (end - begin);
            end = begin;
        }
        if cycle.time <= from {
            break;
        }
    }
    way
}

impl Moves {
    /// Measures the wheels in some episodes; `None` without odometers, or if nothing moved.
    pub fn of(lives: &[Logged]) -> Option<Self> {
        let (longest, step) = LATENCIES;
        let latencies = (0..=(longest / step) as u32).map(|tried| f64::from(tried) * step);
        let (latency, _) = latencies
            .map(|latency| (latency, Ways::of(lives, latency).squares()))
            .min_by(|one, other| one.1.total_cmp(&other.1))?;
        let ways = Ways::of(lives, latency);
        let gains = [0, 1].map(|wheel| ways.gain(wheel));
        if gains.iter().any(|gain| !gain.is_finite()) {
            return None;
        }
        let mut relative = Vec::new();
        for (wheel, gain) in gains.iter().enumerate() {
            let expected = ways.commanded[wheel].iter().map(|commanded| gain * commanded);
            let moving = expected
                .zip(&ways.travelled[wheel])
                .filter(|(expected, _)| expected.abs() >= LEAST_WAY);
            relative.extend(moving.map(|(expected, travelled)| travelled / expected - 1.0));
        }
        Some(Self {
            gains,
            latency,
            deviation: [0, 1].map(|wheel| variance(&ways.errors(wheel)).sqrt()),
            relative: variance(&relative).sqrt(),
            moving: relative.len(),
        })
    }

    /// The mean gain of both wheels.
    pub(crate) fn mean_gain(&self) -> f64 {
        mean(self.gains)
    }

    /// Whether either wheel is so far from its commands that the simulator's motors should be sampled again.
    pub(crate) fn is_far_off(&self) -> bool {
        self.gains.iter().any(|gain| (gain - 1.0).abs() > FAR_OFF)
    }

    /// Motor noise that spreads moves alike, as a fraction, 0 to 1.
    pub fn noise(&self) -> f64 {
        half_width(self.relative).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Cycle;
    use super::*;

    /// Episodes in which commands change every few cycles. The wheels obey after `latency`, with these gains, and their travel varies
    /// by a uniform fraction.
    fn lives(latency: f64, gains: [f64; 2], spread: f64) -> Vec<Logged> {
        let word = |life: u32, cycle: u32, number: u32| {
            let [word, ..] = oneiro::random::pcg4d([life, cycle, number, 7]);
            f64::from(word >> 8) / f64::from(1 << 24)
        };
        let life = |life: u32| {
            let speed = |cycle: u32, wheel: u32| (160.0 * word(life, cycle / 3, wheel) - 80.0).round();
            // Time of each cycle, sometimes a little late.
            let time = |cycle: u32| 0.1 * f64::from(cycle) + 0.01 * word(life, cycle, 9);
            let mut logged = Logged::default();
            let mut travel = [0.0; 2];
            for cycle in 0..200 {
                logged.cycles.push(Cycle {
                    time: time(cycle),
                    activations: Vec::new(),
                    commanded: [speed(cycle, 0), speed(cycle, 1)],
                    travel: Some(travel),
                    pose: [0.0; 3],
                });
                for wheel in 0..2 {
                    // In steps of half a millisecond.
                    let mut way = 0.0;
                    let (from, to) = (time(cycle), time(cycle + 1));
                    let steps = ((to - from) * 2e3).round() as u32;
                    for step in 0..steps {
                        let at = from + (f64::from(step) + 0.5) / f64::from(steps) * (to - from) - latency;
                        let command = (0..=cycle).rev().find(|earlier| time(*earlier) <= at);
                        way += command.map_or(0.0, |command| speed(command, wheel as u32)) * (to - from)
                            / f64::from(steps);
                    }
                    let noise = 1.0 + spread * (2.0 * word(life, cycle, 3 + wheel as u32) - 1.0);
                    travel[wheel] += gains[wheel] * way * noise;
                }
            }
            logged
        };
        (0..8).map(life).collect()
    }

    #[test]
    fn gains_latency_and_noise_are_found_again() {
        for (latency, gains, spread) in [
            (0.0, [1.0, 1.0], 0.0),
            (0.04, [0.93, 1.05], 0.1),
            (0.13, [1.1, 1.0], 0.2),
        ] {
            let moves = Moves::of(&lives(latency, gains, spread)).unwrap();
            assert!((moves.latency - latency).abs() <= 0.005, "{moves:?}");
            for (found, gain) in moves.gains.iter().zip(gains) {
                assert!((found - gain).abs() < 0.01, "{moves:?}");
            }
            assert!((moves.noise() - spread).abs() < 0.01 + 0.05 * spread, "{moves:?}");
            assert_eq!(moves.is_far_off(), latency > 0.0, "{moves:?}");
        }
    }

    #[test]
    fn without_odometers_or_moves_there_is_nothing() {
        let mut lives = lives(0.0, [1.0; 2], 0.0);
        let mut standing = lives.clone();
        for cycle in standing.iter_mut().flat_map(|life| &mut life.cycles) {
            cycle.commanded = [0.0; 2];
        }
        assert_eq!(Moves::of(&standing), None);
        for cycle in lives.iter_mut().flat_map(|life| &mut life.cycles) {
            cycle.travel = None;
        }
        assert_eq!(Moves::of(&lives), None);
    }
}
