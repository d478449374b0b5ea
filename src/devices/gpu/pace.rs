//! Chooses the number of cycles in one dispatch.

use std::time::Duration;

/// Target duration of a dispatch: long enough to make its overhead negligible, and, even if the next one is twice as
/// slow, a tenth of what desktop drivers consider a hang.
const AIM: Duration = Duration::from_millis(100);

/// Robot-steps of the first dispatch, before the speed is known: a tenth of a second on the slowest useful device.
const FIRST_STEPS: u64 = 1 << 18;

/// Last measured speed of one kernel on one device.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pace {
    measured: Option<Measured>,
}

#[derive(Clone, Copy, Debug)]
struct Measured {
    slots: u64,
    seconds_per_cycle: f64,
}

impl Pace {
    /// Whether a dispatch has been measured.
    pub(super) fn is_known(self) -> bool {
        self.measured.is_some()
    }

    /// Number of cycles for a dispatch of `slots` slots, at least 1.
    pub(super) fn cycles(self, slots: u64) -> u32 {
        let cycles = match self.measured {
            None => FIRST_STEPS / slots.max(1),
            // Fewer slots may take as long (a device that isn't full waits for its slowest), and more take at most
            // proportionally longer. Either way the dispatch stays within its target.
            Some(m) => {
                let growth = (slots as f64 / m.slots.max(1) as f64).max(1.0);
                (AIM.as_secs_f64() / (m.seconds_per_cycle * growth)) as u64
            }
        };
        cycles.clamp(1, u64::from(u32::MAX)) as u32
    }

    /// Updates the speed with the measured time of a dispatch.
    pub(super) fn observe(&mut self, slots: u64, cycles: u32, lasted: Duration) {
        // A clock that stood still would imply an infinite speed.
        let seconds = lasted.as_secs_f64().max(1e-6);
        self.measured = Some(Measured {
            slots,
            seconds_per_cycle: seconds / f64::from(cycles.max(1)),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_device_starts_with_few_steps() {
        assert_eq!(Pace::default().cycles(64), 4096);
        assert_eq!(Pace::default().cycles(1 << 30), 1);
    }

    #[test]
    fn a_dispatch_is_never_planned_to_be_longer_than_aimed_at() {
        let mut pace = Pace::default();
        pace.observe(1000, 10, Duration::from_millis(10));
        assert_eq!(pace.cycles(1000), 100);
        assert_eq!(pace.cycles(2000), 50);
        assert_eq!(pace.cycles(10), 100, "fewer slots are not faster until seen to be");
        pace.observe(1000, 1, Duration::from_secs(3));
        assert_eq!(pace.cycles(1000), 1);
    }
}
