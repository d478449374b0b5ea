//! Connected robots: a driver for each protocol, behind one trait. Only a driver knows how many sensors its robot has.
//!
//! Firmware keeps the last speed for ever when its link falls silent, and a driver can't change that: so a program that drives
//! does it through the guard, which stops the wheels.

// Only this workspace uses it.
#![allow(
    missing_docs,
    clippy::missing_errors_doc,
    clippy::missing_panics_doc,
    clippy::return_self_not_must_use,
    rustdoc::private_intra_doc_links,
    reason = "items whose names do not say everything are documented"
)]
// `clippy.toml` says what has one place only.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub mod address;
mod aseba;
#[cfg(any(test, feature = "testing"))]
#[cfg_attr(not(test), allow(dead_code, reason = "its tests use the rest"))]
pub mod emulated;
mod epuck;
mod epuck2;
pub mod error;
#[cfg(test)]
mod fuzz;
pub mod guard;
pub mod khepera;
pub mod link;
pub(crate) mod realtime;
pub mod recording;
#[cfg(any(test, feature = "testing"))]
pub mod script;
mod talk;
mod thymio;
pub mod tracker;
pub mod vehicle;

#[cfg(test)]
#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../../../tests/mutations/mod.rs"]
mod mutations;

use std::fmt;
use std::time::Duration;

use oneiro_base::exit::Failure;

use address::{Transport, Wire};
use error::{Error, Result};
use guard::Brake;
use link::Link;
use recording::Recording;

/// What a sensor measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, clap::ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Kind {
    /// Infra-red light reflected by objects: the nearer, the higher.
    Proximity,
    /// Ambient light: the brighter, the lower.
    Light,
    /// Infra-red light reflected by the floor: the paler, the higher.
    Ground,
    /// Distance of an object ahead.
    Distance,
    /// Acceleration along an axis.
    Acceleration,
    /// Angular speed about an axis.
    Rotation,
    /// Magnetic flux density along an axis.
    Magnetism,
    /// Loudness.
    Sound,
    /// Temperature.
    Temperature,
    /// 1 while a button is pressed.
    Button,
    /// Measured speed of a wheel, in the unit of its commands.
    WheelSpeed,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = clap::ValueEnum::to_possible_value(self);
        name.map_or(Ok(()), |name| f.write_str(name.get_name()))
    }
}

/// The sensors of one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// What they measure.
    pub kind: Kind,
    /// Their names, in the order of readings.
    pub names: &'static [&'static str],
    /// Unit of a reading; empty for the converter's own.
    pub unit: &'static str,
    /// Minimum and maximum reading. Where a link has no other check, any other is an error.
    pub range: (f64, f64),
}

impl Group {
    /// Whether these could be readings of the group.
    fn accepts(&self, values: &[f64]) -> bool {
        let (low, high) = self.range;
        values.len() == self.names.len() && values.iter().all(|value| (low..=high).contains(value))
    }
}

/// A robot's two wheels. Positive is forwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wheels {
    /// Unit of a commanded speed.
    pub unit: &'static str,
    /// Maximum speed, either way, in that unit.
    pub greatest: i32,
    /// One unit in mm/s.
    pub mm_s: f64,
    /// Distance between the wheels, mm.
    pub base_mm: f64,
    /// Travel of a wheel by one count of its odometer, mm; none without odometers.
    pub mm_per_count: Option<f64>,
}

/// Kind, firmware, sensors, wheels and lights of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// Its kind.
    pub robot: String,
    /// Version of its firmware, in its own words.
    pub firmware: String,
    /// Its sensors.
    pub sensors: Vec<Group>,
    /// Its wheels.
    pub wheels: Wheels,
    /// Names of lights that can be switched.
    pub lights: &'static [&'static str],
}

impl Description {
    /// The sensors of some kinds, in the order of these.
    ///
    /// # Errors
    /// The first kind that the robot lacks.
    pub fn groups(&self, kinds: &[Kind]) -> Result<Vec<Group>> {
        let group = |kind: &Kind| {
            let group = self.sensors.iter().find(|group| group.kind == *kind);
            group.copied().ok_or_else(|| {
                let allowed: Vec<String> = self.sensors.iter().map(|group| group.kind.to_string()).collect();
                self.lacks(&format!("sensors of {kind}"), &allowed.join(", "))
            })
        };
        kinds.iter().map(group).collect()
    }

    /// The number of a light, by its name.
    ///
    /// # Errors
    /// The robot lacks it.
    pub fn light_named(&self, name: &str) -> Result<usize> {
        let light = self.lights.iter().position(|light| *light == name);
        light.ok_or_else(|| {
            let allowed = if self.lights.is_empty() {
                "none".into()
            } else {
                self.lights.join(", ")
            };
            self.lacks(&format!("light {name}"), &allowed)
        })
    }

    /// Checks that the robot has a light.
    ///
    /// # Errors
    /// It has fewer.
    fn light(&self, light: usize) -> Result {
        if light < self.lights.len() {
            return Ok(());
        }
        let allowed = match self.lights.len() {
            0 => "none".into(),
            count => format!("0 to {}", count - 1),
        };
        Err(self.lacks(&format!("light {light}"), &allowed))
    }

    /// Checks that the robot at a link is of the kind that it was.
    ///
    /// # Errors
    /// It is another.
    fn is_still(&self, before: &str, link: &str) -> Result {
        if self.robot == before {
            return Ok(());
        }
        Err(Error::Unknown {
            link: link.into(),
            problem: format!(
                "{before} was there, and now {} answers; connect to it as a new robot",
                self.robot
            ),
        })
    }

    fn lacks(&self, what: &str, allowed: &str) -> Error {
        Error::Unsupported {
            robot: self.robot.clone(),
            what: what.into(),
            allowed: allowed.into(),
        }
    }
}

/// Readings of sensors at one moment. Times are of the link's clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// When it arrived.
    pub at: Duration,
    /// Maximum age of its oldest value then.
    pub age: Duration,
    /// One value a sensor, in the order of the kinds asked for and of the names in each.
    pub values: Vec<f64>,
}

/// How far the wheels have turned. Times are of the link's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Odometry {
    /// When it arrived.
    pub at: Duration,
    /// Its maximum age then.
    pub age: Duration,
    /// Counts of the left and of the right wheel by the robot's own counters, continued where these wrap. They
    /// start over when the robot restarts and when the link is reopened.
    pub counts: [i64; 2],
}

/// The state of a battery.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Battery {
    /// Its voltage, if the robot reports it.
    pub volts: Option<f64>,
    /// Whether it should be charged now.
    pub low: bool,
}

/// A robot with two wheels. A call returns once the robot has answered, where its protocol has answers, and never waits for
/// ever. [`Error::Restarted`] is returned once by the first call after a restart that was noticed.
pub trait Robot: Send {
    /// The robot's description.
    fn description(&self) -> &Description;

    /// Reads all sensors of some kinds.
    ///
    /// # Errors
    /// It lacks a kind, or the link fails.
    fn sense(&mut self, kinds: &[Kind]) -> Result<Reading>;

    /// Sets the speeds of the left and the right wheel, in the robot's unit. Speeds beyond the limit are set to the limit.
    ///
    /// # Errors
    /// The link fails; the wheels may have any speed then.
    fn drive(&mut self, left: i32, right: i32) -> Result;

    /// Stops the wheels, and returns once the robot has confirmed it.
    ///
    /// # Errors
    /// The robot has not: the wheels may be turning.
    fn stop(&mut self) -> Result;

    /// The bytes that stop the wheels, whatever was sent before. The guard also sends them between two of the driver's writes, so
    /// the driver skips their answer.
    fn halt(&self) -> Vec<u8>;

    /// The same as [`Robot::stop`] with a proof that takes no longer than a guard can wait, which may miss wheels that creep.
    ///
    /// # Errors
    /// As [`Robot::stop`].
    fn stop_briefly(&mut self) -> Result {
        self.stop()
    }

    /// Makes the robot itself stop its wheels when no more commands arrive, from the next command on, if it can do that.
    ///
    /// # Errors
    /// The link fails.
    fn arm(&mut self) -> Result {
        Ok(())
    }

    /// Switches a light of the description.
    ///
    /// # Errors
    /// There is no such light, or the link fails.
    fn light(&mut self, light: usize, on: bool) -> Result;

    /// Reads the state of the battery.
    ///
    /// # Errors
    /// The robot does not report it, or the link fails.
    fn battery(&mut self) -> Result<Battery>;

    /// Whether the robot is held in the air, as far as its sensors show.
    ///
    /// # Errors
    /// It has no sensors that show it, or the link fails.
    fn lifted(&mut self) -> Result<bool> {
        Err(self
            .description()
            .lacks("sensors that show whether it is lifted", "none"))
    }

    /// Reads how far the wheels have turned.
    ///
    /// # Errors
    /// The robot has no odometers, or the link fails.
    fn odometry(&mut self) -> Result<Odometry>;

    /// Opens the link again, stops the wheels and makes sure that the same kind of robot answers.
    ///
    /// # Errors
    /// The link can't be opened, or another robot answers.
    fn reconnect(&mut self) -> Result;

    /// Stops the wheels and closes the link.
    ///
    /// # Errors
    /// The stop was not confirmed.
    fn close(mut self: Box<Self>) -> Result {
        self.stop()
    }

    /// Sets the speeds of the wheels in mm/s, each to the robot's nearest speed. NaN is 0.
    ///
    /// # Errors
    /// As [`Robot::drive`].
    fn drive_mm_s(&mut self, left: f64, right: f64) -> Result {
        let unit = self.description().wheels.mm_s;
        let [left, right] = [left, right].map(|speed| (speed / unit).round() as i32);
        self.drive(left, right)
    }
}

/// Whether gravity, measured along three axes, points away from the third one by more than 30 degrees: the robot is
/// tilted, for example because a person picks it up. The limit is ours; no floor that these robots can climb is as
/// steep.
fn is_tilted(gravity: &[f64]) -> bool {
    let length = gravity.iter().map(|part| part * part).sum::<f64>().sqrt();
    // Without any acceleration it falls.
    gravity[2] <= length * 0.75_f64.sqrt()
}

/// Counters of some bits, at most 32, that wrap, continued beyond. They must be read before a wheel has made half as many
/// counts as they have.
#[derive(Clone, Copy, Debug, Default)]
struct Unwrapped<const BITS: u32> {
    last: Option<[i64; 2]>,
    total: [i64; 2],
}

impl<const BITS: u32> Unwrapped<BITS> {
    /// By how much the counters have changed; none before they have been read.
    fn change(&self, counts: [impl Into<i64>; 2]) -> Option<[i64; 2]> {
        let counts = counts.map(Into::into);
        let spare = i64::BITS - BITS;
        let last = self.last?;
        Some([0, 1].map(|wheel| (counts[wheel] - last[wheel]) << spare >> spare))
    }

    fn next(&mut self, counts: [impl Into<i64>; 2]) -> [i64; 2] {
        let counts = counts.map(Into::into);
        self.total = match self.change(counts) {
            None => counts,
            Some(change) => [0, 1].map(|wheel| self.total[wheel] + change[wheel]),
        };
        self.last = Some(counts);
        self.total
    }
}

/// Baud rates that Kheperas and e-pucks use, the likeliest first.
const BAUD_RATES: [u32; 5] = [115_200, 9600, 38_400, 19_200, 57_600];

/// Connects to a robot, finds out what it is, and stops its wheels.
///
/// # Errors
/// The link can't be opened, or no known robot answers.
pub fn connect(wire: &Wire, recording: Option<&Recording>) -> Result<Box<dyn Robot>> {
    connect_braked(wire, recording, &Brake::default())
}

/// The same, with a brake on the link.
///
/// # Errors
/// As [`connect`].
fn connect_braked(wire: &Wire, recording: Option<&Recording>, brake: &Brake) -> Result<Box<dyn Robot>> {
    let open = |transport: &Transport| -> Result<Box<dyn Link>> {
        let link = brake.on(link::open(transport)?, recording.and_then(Recording::aside));
        Ok(match recording {
            Some(recording) => recording.of(link),
            None => link,
        })
    };
    let transport = match wire {
        Wire::Aseba { transport, node } => return Ok(Box::new(thymio::Thymio::connect(open(transport)?, *node)?)),
        Wire::Plain(transport) => transport,
    };
    let (robots, transports) = match transport {
        Transport::Tcp { .. } => {
            // First, since a stray byte would put the e-puck2's radio out of step with its commands.
            if let Some(robot) = epuck2::EPuck2::connect(open(transport)?)? {
                return Ok(Box::new(robot));
            }
            (
                "e-puck2 (Wi-Fi), e-puck or Khepera answers".into(),
                vec![transport.clone()],
            )
        }
        Transport::Serial { baud: Some(baud), .. } => (
            format!("e-puck or Khepera answers at {baud} baud"),
            vec![transport.clone()],
        ),
        // A Bluetooth channel has no baud rate.
        Transport::Serial { path, baud: None } if link::is_bluetooth(path) => {
            ("e-puck or Khepera answers".into(), vec![transport.clone()])
        }
        Transport::Serial { path, baud: None } => {
            let at = |baud| Transport::Serial {
                path: path.clone(),
                baud: Some(baud),
            };
            (
                "e-puck or Khepera answers at 9600 to 115200 baud".into(),
                BAUD_RATES.map(at).into(),
            )
        }
    };
    for transport in &transports {
        if let Some(robot) = recognise(open(transport)?)? {
            return Ok(robot);
        }
    }
    Err(Error::Unknown {
        link: transport.to_string(),
        problem: format!(
            "no {robots}; check that it is on, in the mode for remote control, and used by no other program; for a \
             Thymio II, write aseba: before the address"
        ),
    })
}

/// The robot that talks in lines at the end of a link; none if nothing known answers. An e-puck is asked for first: its `V`
/// is unknown to a Khepera, but a Khepera's `B` would switch an e-puck's light off.
///
/// # Errors
/// A robot answers and does not stop, or the link fails.
fn recognise(link: Box<dyn Link>) -> Result<Option<Box<dyn Robot>>> {
    let mut epuck = epuck::EPuck::new(link);
    match epuck.begin() {
        Ok(()) => return Ok(Some(Box::new(epuck))),
        Err(error) if error.may_pass() && !epuck.has_answered() => {}
        Err(error) => return Err(error),
    }
    let mut khepera = khepera::Khepera::new(epuck.into_link());
    match khepera.begin() {
        Ok(()) => Ok(Some(Box::new(khepera))),
        Err(error) if error.may_pass() && !khepera.has_answered() => Ok(None),
        Err(error) => Err(error),
    }
}

/// Stops a robot. A restart that it reports first is no confirmation.
///
/// # Errors
/// The stop was not confirmed.
pub fn stopped(robot: &mut dyn Robot) -> Result {
    match robot.stop() {
        Err(Error::Restarted) => robot.stop(),
        outcome => outcome,
    }
}

/// Says that the wheels may be turning, and what to do.
pub fn unstopped(error: &Error) -> Failure {
    Failure::device(format_args!(
        "cannot stop: {error}. The wheels may be turning: lift the robot, then switch it off or reset it"
    ))
}

#[cfg(test)]
mod tests;
