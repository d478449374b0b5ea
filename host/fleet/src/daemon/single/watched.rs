//! Pings systemd's watchdog whenever the daemon uses its robot. A daemon that neither reads the sensors nor waits for a few seconds has
//! hung, and systemd restarts it.

use std::cell::Cell;
use std::time::Duration;

use oneiro_robots::vehicle::trouble::Trouble;
use oneiro_robots::vehicle::{Moment, Profile, Vehicle};

use crate::daemon::notify::Notify;

/// Minimum time between two pings: several fit into the `WatchdogSec` of the daemon's unit.
const PERIOD: Duration = Duration::from_secs(1);

/// A robot that pings the watchdog.
pub(super) struct Watched {
    vehicle: Box<dyn Vehicle + Send>,
    notify: Notify,
    /// When it pinged last, by the robot's clock.
    pinged: Cell<Option<Duration>>,
}

impl Watched {
    pub(super) fn new(vehicle: Box<dyn Vehicle + Send>, notify: Notify) -> Self {
        Self {
            vehicle,
            notify,
            pinged: Cell::new(None),
        }
    }

    /// Pings, unless the last ping was less than [`PERIOD`] ago.
    fn ping(&self) {
        let now = self.vehicle.now();
        if self.pinged.get().is_none_or(|pinged| now >= pinged + PERIOD) {
            self.pinged.set(Some(now));
            self.notify.watchdog();
        }
    }
}

impl Vehicle for Watched {
    fn profile(&self) -> &Profile {
        self.vehicle.profile()
    }

    fn now(&self) -> Duration {
        self.vehicle.now()
    }

    fn look(&mut self) -> Result<Moment, Trouble> {
        self.ping();
        self.vehicle.look()
    }

    fn drive(&mut self, speeds: [f64; 2]) -> Result<(), Trouble> {
        self.vehicle.drive(speeds)
    }

    fn keep_until(&mut self, until: Duration) -> Result<(), Trouble> {
        self.ping();
        self.vehicle.keep_until(until)
    }

    fn stop(&mut self) -> Result<(), Trouble> {
        self.vehicle.stop()
    }

    fn volts(&self) -> Option<f64> {
        self.vehicle.volts()
    }

    fn seen(&self) -> Option<[f64; 3]> {
        self.vehicle.seen()
    }

    fn ask(&mut self, what: &str) -> Result<(), Trouble> {
        self.vehicle.ask(what)
    }

    fn recover(&mut self) -> Result<(), Trouble> {
        self.recover_until(&|| false)
    }

    fn recover_until(&mut self, is_over: &dyn Fn() -> bool) -> Result<(), Trouble> {
        // The clock of the vehicle can't be read meanwhile.
        let notify = &self.notify;
        self.vehicle.recover_until(&|| {
            notify.watchdog();
            is_over()
        })
    }

    fn resume(&mut self) {
        self.vehicle.resume();
    }
}
