//! Clocks that drift and jump. Times are in ns.

/// The clock of a robot's computer, by the conductor's.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LocalClock {
    /// A moment on the conductor's clock, and on this one.
    since: u64,
    shown: u64,
    /// How much faster this one runs, in 10^-12.
    faster: i128,
}

impl LocalClock {
    const WHOLE: i128 = 1_000_000_000_000;

    /// What it shows at a moment of the conductor's clock, not before the last change.
    pub(super) fn shows(&self, at: u64) -> u64 {
        let passed = i128::from(at.saturating_sub(self.since));
        self.shown + (passed * (Self::WHOLE + self.faster) / Self::WHOLE) as u64
    }

    /// The first moment of the conductor's clock at which it shows at least this.
    pub(super) fn reaches(&self, shown: u64) -> u64 {
        let passed = i128::from(shown.saturating_sub(self.shown));
        let rate = Self::WHOLE + self.faster;
        let at = (passed * Self::WHOLE + rate - 1) / rate;
        u64::try_from(at).unwrap_or(u64::MAX).saturating_add(self.since)
    }

    /// Jumps forward, and from now on runs faster by `ppm` millionths.
    pub(super) fn change(&mut self, now: u64, ppm: f64, jump: u64) {
        *self = Self {
            since: now,
            shown: self.shows(now) + jump,
            faster: (ppm * 1e6) as i128,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_is_reached_when_it_shows_the_time() {
        let mut clock = LocalClock::default();
        assert_eq!((clock.shows(5), clock.reaches(7)), (5, 7));
        for (now, ppm, jump) in [
            (10, 200.0, 0),
            (1_000_000_007, -1000.0, 3),
            (5_000_000_000, 0.5, 1_500_000_000),
        ] {
            let before = clock.shows(now);
            clock.change(now, ppm, jump);
            assert_eq!(clock.shows(now), before + jump);
            for later in [0, 1, 999_999, 86_400_000_000_001] {
                let shown = clock.shows(now) + later;
                let at = clock.reaches(shown);
                assert!(
                    clock.shows(at) >= shown && (at == now || clock.shows(at - 1) < shown),
                    "{ppm} {later}"
                );
            }
        }
        // 200 millionths of 10 s are 2 ms.
        let mut clock = LocalClock::default();
        clock.change(0, 200.0, 0);
        assert_eq!(clock.shows(10_000_000_000), 10_002_000_000);
        assert_eq!(clock.reaches(u64::MAX), 18_443_055_462_617_028_210);
    }
}
