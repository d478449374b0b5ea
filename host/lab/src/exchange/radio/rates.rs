//! How many datagrams are accepted: token buckets.

use std::time::Duration;

use super::OPERATOR;

/// How fast a bucket fills, and what it holds.
pub(super) struct Rate {
    /// From one datagram to the next.
    period: Duration,
    /// How many may come at once.
    burst: u32,
}

/// A robot's: it sends a pair and a status a second, and a hello until it has received a beacon. Its datagrams of 2 s may come at once,
/// after the radio was jammed.
const ROBOT: Rate = Rate {
    period: Duration::from_millis(200),
    burst: 10,
};

/// The operator's: a beacon ten times a second, or each one twice where datagrams are lost, and a hello a second.
const BEACONS: Rate = Rate {
    period: Duration::from_millis(40),
    burst: 50,
};

/// Datagrams that are authenticated, whoever sent them: 128 robots, the maximum of a swarm, and the operator may send about 700 a
/// second. At 10 us each, on a slow processor, 2000 take 2 % of its time.
pub(super) const ALL: Rate = Rate {
    period: Duration::from_micros(500),
    burst: 500,
};

/// The rate of a sender.
pub(super) fn of(sender: u16) -> &'static Rate {
    if sender == OPERATOR { &BEACONS } else { &ROBOT }
}

/// A bucket of tokens, as the time at which it is full again.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bucket(Duration);

impl Bucket {
    /// Takes a token, if there is one.
    pub(super) fn take(&mut self, rate: &Rate, now: Duration) -> bool {
        let full = self.0.max(now) + rate.period;
        let has_token = full <= now + rate.period * rate.burst;
        if has_token {
            self.0 = full;
        }
        has_token
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_burst_is_taken_at_once_and_then_one_a_period() {
        for rate in [&ROBOT, &BEACONS, &ALL] {
            let start = Duration::from_secs(1000);
            let mut bucket = Bucket::default();
            let at_once = (0..1000).filter(|_| bucket.take(rate, start)).count();
            assert_eq!(at_once, rate.burst as usize);
            assert!(!bucket.take(rate, start + rate.period.saturating_sub(Duration::from_nanos(1))));
            assert!(bucket.take(rate, start + rate.period) && !bucket.take(rate, start + rate.period));
            // Twice as many as are allowed, for a long time: one half is taken.
            let (many, start) = (10_000, start + rate.period);
            let taken = (1..=many)
                .filter(|time| bucket.take(rate, start + rate.period / 2 * *time))
                .count();
            assert_eq!(taken as u32, many / 2);
            // Full again after a pause, and no fuller.
            let later = start + Duration::from_hours(1);
            assert_eq!(
                (0..1000).filter(|_| bucket.take(rate, later)).count(),
                rate.burst as usize
            );
        }
    }
}
