//! A robot's clock: when its intervals begin, and when controllers take over. Seconds count from the moment at which the
//! first robot may be switched on.

use std::ops::Range;

use oneiro::swarm::{Order, SECOND};
use oneiro_evolve::encapsulated::Genome;
use serde::{Deserialize, Serialize};

/// A robot's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Clock {
    /// The second at which the robot is switched on and its first interval begins.
    pub offset: u32,
    /// Seconds of an interval.
    pub interval: u32,
    /// The second of an interval at which the controller that its simulations chose takes over, at most the last.
    pub installed: u32,
}

impl Clock {
    /// The interval that a second belongs to; none before it is switched on.
    pub fn interval_at(self, second: u32) -> Option<u32> {
        Some(second.checked_sub(self.offset)? / self.interval)
    }

    /// The seconds of an interval.
    pub fn seconds_of(self, interval: u32) -> Range<u32> {
        let first = self.offset + interval * self.interval;
        first..first + self.interval
    }

    /// The interval whose simulations chose the controller that acts in a second; none if that is the first controller.
    pub fn chosen_in(self, second: u32) -> Option<u32> {
        Some(second.checked_sub(self.offset + self.installed)? / self.interval)
    }

    /// The robot's order for some seconds, no more of them than an interval has. `first` is the controller that it starts
    /// with, `chosen` are those that the simulations of its intervals chose.
    pub fn order(self, seconds: Range<u32>, first: Genome, chosen: &[Genome]) -> Order {
        let genes = |second: u32| {
            self.chosen_in(second)
                .map_or(first, |interval| chosen[interval as usize])
        };
        let is_on = |second: u32| second >= self.offset;
        let changes = seconds
            .clone()
            .skip(1)
            .find(|&second| is_on(second) != is_on(second - 1) || self.chosen_in(second) != self.chosen_in(second - 1));
        let at = changes.unwrap_or(seconds.start);
        let begins = seconds
            .clone()
            .find(|&second| is_on(second) && (second - self.offset).is_multiple_of(self.interval));
        Order {
            before: is_on(seconds.start).then(|| genes(seconds.start)),
            after: genes(at.max(self.offset)),
            at: SECOND * if is_on(at) { at } else { seconds.end },
            begins: begins.map(|second| SECOND * second),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHOSEN: [Genome; 3] = [[0.1; 2], [0.2; 2], [0.3; 2]];
    const FIRST: Genome = [0.9; 2];

    /// The gene that acts in each second under the orders of consecutive stretches, and the beginnings of intervals.
    fn followed(clock: Clock, cuts: &[u32]) -> (Vec<Option<f32>>, Vec<u32>) {
        let mut acts = Vec::new();
        let mut begins = Vec::new();
        for pair in cuts.windows(2) {
            let order = clock.order(pair[0]..pair[1], FIRST, &CHOSEN);
            for second in pair[0]..pair[1] {
                let genes = if SECOND * second >= order.at {
                    Some(order.after)
                } else {
                    order.before
                };
                acts.push(genes.map(|genes| genes[0]));
            }
            begins.extend(order.begins.map(|cycle| cycle / SECOND));
        }
        (acts, begins)
    }

    #[test]
    fn orders_follow_the_clock_wherever_stretches_are_cut() {
        for offset in [0, 3, 5] {
            for installed in [60, 34] {
                let clock = Clock {
                    offset,
                    interval: 60,
                    installed,
                };
                let (acts, begins) = followed(clock, &[0, 5, 65, 125, 180]);
                for (second, acts) in (0..).zip(&acts) {
                    let expected = if second < offset {
                        None
                    } else if second < offset + installed {
                        Some(FIRST[0])
                    } else {
                        Some(CHOSEN[((second - offset - installed) / 60) as usize][0])
                    };
                    assert_eq!(
                        *acts, expected,
                        "offset {offset}, installed {installed}, second {second}"
                    );
                }
                let expected: Vec<u32> = (0..3).map(|interval| offset + 60 * interval).collect();
                assert_eq!(begins, expected);
            }
        }
    }

    #[test]
    fn seconds_belong_to_intervals() {
        let clock = Clock {
            offset: 4,
            interval: 60,
            installed: 60,
        };
        assert_eq!(clock.interval_at(3), None);
        assert_eq!(
            (clock.interval_at(4), clock.interval_at(63), clock.interval_at(64)),
            (Some(0), Some(0), Some(1))
        );
        assert_eq!(clock.seconds_of(1), 64..124);
        assert_eq!((clock.chosen_in(63), clock.chosen_in(64)), (None, Some(0)));
    }
}
