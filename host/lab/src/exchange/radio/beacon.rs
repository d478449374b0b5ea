//! The operator's beacons: the experiment's time, and the dead man's switch.

use std::ops::RangeInclusive;
use std::time::Duration;

/// Default time after a beacon was sent for which robots may move, ms. A daemon acts once in 100 ms, so wheels stand 0.5 s after
/// the last beacon.
pub const LIMIT_MS: u64 = 400;
/// Allowed limits, ms: at least the time from one beacon to the next.
pub const LIMITS_MS: RangeInclusive<u64> = 100..=450;

/// Maximum that a clock may gain or lose against the operator's in a second, us: 500 ppm, five times the usual tolerance of quartz
/// crystals.
const DRIFT: i64 = 500;
const SECOND: i64 = 1_000_000;

/// What a robot derives from the operator's beacons. The robot's clock may be any that never goes back.
///
/// A beacon arrives at the time of its sending plus a delay, so the minimum difference of the two clocks over all beacons is the best
/// estimate. The difference counts as [`DRIFT`] more with each second that passes: a late beacon does not shift the time, and a
/// drifting clock is followed. So the time is never ahead of the operator's.
#[derive(Clone, Debug)]
pub struct Beacons {
    limit: Duration,
    latest: Option<Latest>,
    /// Minimum of the experiment's time, us: where it was when the operator's program started again.
    floor: i64,
}

/// What follows from the beacons of one start of the operator's program.
#[derive(Clone, Copy, Debug)]
struct Latest {
    /// Lead of the robot's clock on the experiment's, us, by the beacon received at `at` on the robot's clock, and those before.
    lead: i64,
    at: i64,
    /// The newest beacon's number, which begins with that of the operator's start.
    sequence: u64,
    /// When it was sent, in the experiment's time, us.
    sent: i64,
    /// Whether robots may move by it.
    go: bool,
}

impl Latest {
    /// The maximum lead of the robot's clock by now.
    fn lead_at(&self, now: i64) -> i64 {
        self.lead + (now - self.at).max(0) * DRIFT / SECOND
    }
}

impl Beacons {
    /// No beacon has been received yet. `limit` is within [`LIMITS_MS`].
    pub fn new(limit: Duration) -> Self {
        Self {
            limit,
            latest: None,
            floor: i64::MIN,
        }
    }

    /// Receives a beacon: its number, its time of the experiment, ms, and whether robots may move.
    ///
    /// If the operator's clock jumps back, its beacons count as late, so robots stand until its program has started again. Then the
    /// experiment's time goes on from the new beacons, and stands where it would go back.
    pub fn hear(&mut self, sequence: u64, milliseconds: i64, go: bool, now: Duration) {
        let (at, sent) = (micros(now), milliseconds.saturating_mul(1000));
        let lead = at.saturating_sub(sent);
        let start = |sequence: u64| sequence >> 32;
        let own = match self.latest {
            Some(latest) if start(sequence) < start(latest.sequence) => return,
            Some(latest) if start(sequence) == start(latest.sequence) => Some(latest),
            _ => {
                self.floor = self.micros(now).unwrap_or(self.floor);
                None
            }
        };
        let newest = own.filter(|latest| sequence < latest.sequence);
        self.latest = Some(Latest {
            lead: own.map_or(lead, |latest| latest.lead_at(at).min(lead)),
            at,
            ..newest.unwrap_or(Latest {
                lead,
                at,
                sequence,
                sent,
                go,
            })
        });
    }

    /// The experiment's time, ms: that of the beacons, and between them by the robot's clock. It never goes back. `None` before the
    /// first beacon.
    pub fn time(&self, now: Duration) -> Option<i64> {
        Some(self.micros(now)?.div_euclid(1000))
    }

    /// The second of the experiment, if it has begun.
    pub fn second(&self, now: Duration) -> Option<u32> {
        self.time(now)?.div_euclid(1000).try_into().ok()
    }

    /// Whether wheels may turn: the newest beacon allows it, and was sent no longer ago than the limit. A beacon that arrives late
    /// gives no more time.
    pub fn may_move(&self, now: Duration) -> bool {
        self.latest.is_some_and(|latest| {
            let age = micros(now) - latest.lead - latest.sent;
            latest.go && age <= micros(self.limit)
        })
    }

    fn micros(&self, now: Duration) -> Option<i64> {
        let now = micros(now);
        let latest = self.latest?;
        Some((now - latest.lead_at(now)).max(self.floor))
    }
}

fn micros(time: Duration) -> i64 {
    time.as_micros() as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use oneiro_robots::script::Random;

    const LIMIT: Duration = Duration::from_millis(LIMIT_MS);

    /// A robot whose clock drifts, and the operator's beacons on their way to it. Times are without drift, ms.
    struct Trial {
        random: Random,
        beacons: Beacons,
        /// How much faster the robot's clock is, ppm.
        drift: i64,
        /// Chance that a beacon is lost, percent, and its maximum extra delay, ms.
        loss: usize,
        jitter: usize,
        boots: u64,
        counter: u64,
        /// Lead of the operator's clock, ms.
        ahead: i64,
        now: i64,
        coming: Vec<(i64, u64, i64, bool)>,
        /// When the newest beacon with go was sent.
        sent: Option<i64>,
        time: Option<i64>,
    }

    impl Trial {
        /// The minimum delay, ms.
        const DELAY: i64 = 2;

        fn new(drift: i64, loss: usize, jitter: usize) -> Self {
            Self {
                random: Random(drift as u64 ^ 9),
                beacons: Beacons::new(LIMIT),
                drift,
                loss,
                jitter,
                boots: 7,
                counter: 0,
                ahead: -5000,
                now: 0,
                coming: Vec::new(),
                sent: None,
                time: None,
            }
        }

        fn own(&self) -> Duration {
            let micros = 3_000_000_000 + self.now * 1000 + self.now * self.drift / 1000;
            Duration::from_micros(micros as u64)
        }

        /// Lets time pass while the operator sends beacons with `go`, or none. Returns the fraction of it in which the robot may move,
        /// and the maximum error of its time at the end of each millisecond, ms.
        fn pass(&mut self, milliseconds: i64, go: Option<bool>) -> (f64, i64) {
            let (mut moves, mut error) = (0, 0);
            for _ in 0..milliseconds {
                self.now += 1;
                if let (Some(go), 0) = (go, self.now % 100) {
                    self.counter += 1;
                    let lost = self.random.below(100) < self.loss;
                    let late = self.random.below(self.jitter + 1) as i64;
                    if !lost {
                        let sequence = self.boots << 32 | self.counter;
                        let arrives = self.now + Self::DELAY + late;
                        self.coming.push((arrives, sequence, self.now + self.ahead, go));
                        self.sent = if go { Some(self.now) } else { self.sent };
                    }
                }
                let now = self.now;
                for (_, sequence, milliseconds, go) in self.coming.extract_if(.., |(at, ..)| *at == now) {
                    let own = Duration::from_micros((3_000_000_000 + now * 1000 + now * self.drift / 1000) as u64);
                    self.beacons.hear(sequence, milliseconds, go, own);
                }
                let own = self.own();
                if let Some(time) = self.beacons.time(own) {
                    assert!(self.time <= Some(time), "{:?} and then {time}", self.time);
                    self.time = Some(time);
                    error = error.max(self.now + self.ahead - time);
                }
                moves += u32::from(self.beacons.may_move(own));
            }
            (f64::from(moves) / milliseconds as f64, error)
        }

        fn error(&self) -> i64 {
            self.now + self.ahead - self.time.unwrap()
        }
    }

    /// Never ahead, hardly behind, and moving most of the time: lost and late beacons explain the rest.
    #[test]
    fn time_follows_a_drifting_clock_through_loss_jitter_and_reordering() {
        for drift in [-500, -20, 0, 20, 500] {
            let mut trial = Trial::new(drift, 30, 198);
            assert_eq!(trial.beacons.time(trial.own()), None);
            trial.pass(30_000, Some(true));
            let (moves, error) = trial.pass(90_000, Some(true));
            assert!(trial.error() >= -1 && error <= 35, "{drift} ppm: {error} ms");
            assert!((0.93..0.99).contains(&moves), "{drift} ppm: {moves}");
            // Without any beacon for an hour the clock runs on, and the first beacon corrects it.
            trial.now += 3_600_000;
            let (moves, error) = trial.pass(1000, None);
            assert!(
                moves == 0.0 && error <= 1800 + 1800 + 40,
                "{drift} ppm: {moves} {error}"
            );
            trial.pass(10_000, Some(true));
            let (_, error) = trial.pass(30_000, Some(true));
            assert!(error <= 60, "{drift} ppm: {error} ms after the hour");
        }
    }

    /// On a good network robots may always move, and the time is right except for the delay.
    #[test]
    fn without_faults_nothing_is_late() {
        let mut trial = Trial::new(100, 0, 0);
        trial.pass(1000, Some(true));
        let (moves, error) = trial.pass(100_000, Some(true));
        assert!(moves == 1.0 && error <= Trial::DELAY + 1, "{moves} {error}");
    }

    /// Wheels may turn for the limit after the last beacon was sent, however late it came. They may not turn after a beacon without go,
    /// even if an older one comes after it.
    #[test]
    fn robots_move_only_while_they_hear_beacons() {
        for (loss, jitter, drift) in [(0, 0, 0), (30, 198, 500), (30, 198, -500)] {
            let mut trial = Trial::new(drift, loss, jitter);
            for _ in 0..20 {
                trial.pass(3000, Some(true));
                let last = trial.sent.unwrap();
                let mut moved = last;
                while trial.now < last + 1000 {
                    trial.pass(1, None);
                    if trial.beacons.may_move(trial.own()) {
                        moved = trial.now;
                    }
                }
                assert!(moved - last <= LIMIT_MS as i64 + 40, "{} ms", moved - last);
                assert!(loss > 0 || moved - last >= LIMIT_MS as i64, "{} ms", moved - last);
            }
        }
        // With a daemon's cycle, at the default.
        assert!(LIMITS_MS.contains(&LIMIT_MS) && LIMIT_MS + 100 <= 500);
        let ms = Duration::from_millis;
        let mut beacons = Beacons::new(LIMIT);
        assert!(!beacons.may_move(ms(0)));
        beacons.hear(1, 0, true, ms(1000));
        beacons.hear(2, 100, true, ms(1100));
        beacons.hear(4, 300, false, ms(1300));
        assert!(!beacons.may_move(ms(1300)));
        beacons.hear(3, 200, true, ms(1310));
        assert!(!beacons.may_move(ms(1310)), "an older go");
        beacons.hear(5, 400, true, ms(1400));
        assert!(beacons.may_move(ms(1800)) && !beacons.may_move(ms(1801)));
        // Held back by a second, one after the other: they contain their old time, and let nothing move.
        for late in 6..100 {
            beacons.hear(late, 100 * late as i64 - 100, true, ms(900 + 100 * late + 1000));
            assert!(!beacons.may_move(ms(900 + 100 * late + 1000)), "{late}");
        }
    }

    /// A new start of the operator's program may bring another time. Robots take it, but the experiment's time never goes back.
    #[test]
    fn a_clock_that_jumps_is_followed_once_it_has_been_announced() {
        for jump in [-3000, 7000] {
            let mut trial = Trial::new(50, 30, 198);
            trial.pass(30_000, Some(true));
            trial.ahead += jump;
            let (moves, _) = trial.pass(20_000, Some(true));
            assert_eq!(moves < 0.1, jump < 0, "{jump} ms, not announced: {moves}");
            trial.boots += 1;
            trial.counter = 0;
            trial.pass(5000, Some(true));
            let (moves, _) = trial.pass(30_000, Some(true));
            assert!(
                moves > 0.9 && (-1..=60).contains(&trial.error()),
                "{jump} ms: {moves} {}",
                trial.error()
            );
            // A beacon of the previous start comes late.
            let (own, boots) = (trial.own(), trial.boots - 1);
            trial.beacons.hear(boots << 32 | 0xffff, 1 << 40, true, own);
            trial.pass(1, Some(true));
            assert!(trial.error() >= -1);
        }
    }

    #[test]
    fn seconds_begin_with_the_experiment() {
        let mut beacons = Beacons::new(LIMIT);
        let second = |beacons: &Beacons, ms| beacons.second(Duration::from_millis(ms));
        assert_eq!(second(&beacons, 0), None);
        beacons.hear(1, -1500, true, Duration::from_secs(10));
        assert_eq!((second(&beacons, 11_499), second(&beacons, 11_502)), (None, Some(0)));
        assert_eq!(beacons.time(Duration::from_secs(10)), Some(-1500));
    }
}
