//! A robot for episodes and sampling: it senses, drives, and keeps time. Behind it is the guard's process, or in tests
//! a driver on a virtual clock.

#[cfg(any(test, feature = "testing"))]
pub mod direct;
pub mod guarded;
pub mod late;
pub mod person;
pub mod trouble;

use std::time::Duration;

use super::guard::message::Sensors;
use trouble::Trouble;

/// A robot's description for episodes and sampling.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Its kind.
    pub robot: String,
    /// Version of its firmware, in its own words.
    pub firmware: String,
    /// The sensors that are read, in the order of [`Moment::readings`].
    pub sensors: Vec<Sensors>,
    /// Maximum allowed speed of a wheel, mm/s.
    pub greatest_mm_s: f64,
    /// One of the robot's own units of speed, mm/s.
    pub unit_mm_s: f64,
    /// Distance between the wheels, mm.
    pub base_mm: f64,
    /// Whether it measures how far its wheels have turned.
    pub has_odometers: bool,
}

/// What a robot senses at one moment. Times are of [`Vehicle::now`].
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// When the last of it arrived.
    pub at: Duration,
    /// Maximum age of a reading then.
    pub age: Duration,
    /// One value per sensor, in the sensors' own units.
    pub readings: Vec<f64>,
    /// Travel of the left and of the right wheel since the vehicle was opened, mm; none without odometers.
    pub travel: Option<[f64; 2]>,
}

/// A robot with two wheels that is read and driven, cycle by cycle. After a [`Trouble`] its wheels stand still, or its
/// guard is stopping them; [`Vehicle::recover`] continues.
pub trait Vehicle {
    /// What it is.
    fn profile(&self) -> &Profile;

    /// Time on its clock, which is a virtual one in tests.
    fn now(&self) -> Duration;

    /// Reads all sensors and the odometers.
    ///
    /// # Errors
    /// See [`Trouble`].
    fn look(&mut self) -> Result<Moment, Trouble>;

    /// Sets the speeds of the left and of the right wheel, mm/s.
    ///
    /// # Errors
    /// See [`Trouble`].
    fn drive(&mut self, speeds: [f64; 2]) -> Result<(), Trouble>;

    /// Goes on with the speeds set last until a moment of its clock, which may have passed.
    ///
    /// # Errors
    /// See [`Trouble`].
    fn keep_until(&mut self, until: Duration) -> Result<(), Trouble>;

    /// Stops the wheels, and returns once the robot has confirmed it.
    ///
    /// # Errors
    /// See [`Trouble`].
    fn stop(&mut self) -> Result<(), Trouble>;

    /// The voltage of its battery, if the robot reports it.
    fn volts(&self) -> Option<f64> {
        None
    }

    /// Where a tracker sees it: x and y in mm, heading in turns, 0 to 1. None without a tracker, and while that has lost it.
    fn seen(&self) -> Option<[f64; 3]> {
        None
    }

    /// Asks a person to do something with the robot, whose wheels stand still, and waits until it is done.
    ///
    /// # Errors
    /// See [`Trouble`]; nobody is there.
    fn ask(&mut self, what: &str) -> Result<(), Trouble> {
        Err(Trouble::Broken(format!("nobody is there to do this: {what}")))
    }

    /// After a trouble that may pass, waits until the robot can be driven again; its wheels then stand still. A person
    /// may have to put it back, charge it or confirm.
    ///
    /// # Errors
    /// See [`Trouble`].
    fn recover(&mut self) -> Result<(), Trouble>;

    /// The same, until it is no longer wanted.
    ///
    /// # Errors
    /// See [`Trouble`].
    fn recover_until(&mut self, _is_over: &dyn Fn() -> bool) -> Result<(), Trouble> {
        self.recover()
    }

    /// Asks for permission to drive again after a trouble that may pass, and does not wait for it.
    fn resume(&mut self) {}
}
