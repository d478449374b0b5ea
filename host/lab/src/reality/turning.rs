//! Sampling of a connected robot: it turns on the spot before an object, and drives in the open.
//!
//! Its turning angle is computed from its wheels, or without odometers from its commanded speeds and the clock. Neither is exact:
//! wheels slip, and their distance has an error of a few per cent. But after a whole turn a robot reads the same again, so one
//! measurement before an object shows how far its wheels travel in a whole turn, and each turn continues beyond its beginning as
//! a check.

use std::f64::consts::TAU;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use oneiro::tables::GREATEST_READING;
use oneiro_robots::vehicle::{Moment, Profile, Vehicle};
use serde::{Deserialize, Serialize};

use super::sampling::{self, BEARINGS, Row};
use super::{Driven, Trouble, Turned};
use signal::Signal;

#[cfg(any(test, feature = "testing"))]
pub mod mock;
mod signal;

type Result<T = ()> = std::result::Result<T, Trouble>;

/// A turn is continued past a full revolution by this part of one.
const OVERLAP: f64 = 72.0 / 360.0;
/// Maximum error of a whole turn, within that part.
const MOST_DRIFT: f64 = 12.0 / 360.0;
/// Maximum number of turns added for bearings without a reading.
const MORE_TURNS: u32 = 2;
/// Turns, by the wheels, that are searched for a whole one.
const MEASURED: f64 = 3.3;

/// How a robot turns on the spot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Turning {
    /// Speed of its wheels, mm/s.
    pub wheel_mm_s: f64,
    /// Turns by its wheels, or by the clock, in one whole turn: about 1.
    pub apparent: f64,
}

impl Turning {
    /// Duration of a sample before an object, s.
    pub fn seconds(self, base_mm: f64, turns: u32) -> f64 {
        let rate = 2.0 * self.wheel_mm_s / (TAU * base_mm);
        (f64::from(turns) + 2.0 * OVERLAP) * self.apparent / rate
    }
}

/// Readings as the robot turns.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    /// Bearings of the object since the beginning, turns clockwise, beyond the first turn as well, and the readings there.
    signal: Signal,
    turns: u32,
    /// How its end agrees with its beginning.
    pub overlap: Overlap,
}

/// How the end of some turns agrees with their beginning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Overlap {
    /// Readings are the same all the way round, so the end of a turn can't be recognised.
    Blank,
    /// Readings do not recur.
    Unlike,
    /// Whole turns end late by `drift`; the mean difference of any sensor's readings is then at most `difference`.
    Late {
        /// Turns.
        drift: f64,
        /// Of a sensor's range of 1023.
        difference: f64,
    },
}

impl Turn {
    /// Readings in order of time.
    #[cfg(test)]
    pub fn turned(&self) -> Vec<Turned> {
        self.signal.turned(f64::NEG_INFINITY, f64::INFINITY)
    }

    /// The mean readings at each bearing. A reading is the first one in the bearing's interval of a turn; a turn without one
    /// is made up by a later one.
    ///
    /// # Errors
    /// The first bearing without a reading.
    pub fn row(&self) -> std::result::Result<Row, u32> {
        let last = self.signal.end().floor().max(0.0) as u32;
        let each: Vec<_> = (0..=last)
            .map(|turn| sampling::first_readings(&self.signal.turned(f64::from(turn), f64::from(turn + 1))))
            .collect();
        let cell = |bearing: u32| {
            let cells = each.iter().filter_map(|turn| turn[bearing as usize].as_deref());
            match &cells.take(self.turns as usize).collect::<Vec<_>>()[..] {
                [] => Err(bearing),
                cells => Ok(sampling::mean(cells)),
            }
        };
        (0..BEARINGS).map(cell).collect()
    }
}

/// Measures how far a robot has turned counter-clockwise, by its wheels or by the clock.
struct Compass {
    base_mm: f64,
    travel: Option<[f64; 2]>,
    /// Without odometers: how far it had turned when it began to turn at a rate, turns/s.
    turned: f64,
    since: Duration,
    rate: f64,
}

impl Compass {
    fn new(vehicle: &mut dyn Vehicle) -> Result<Self> {
        Ok(Self {
            base_mm: vehicle.profile().base_mm,
            travel: vehicle.look()?.travel,
            turned: 0.0,
            since: vehicle.now(),
            rate: 0.0,
        })
    }

    fn turned(&self, moment: &Moment) -> f64 {
        match (self.travel, moment.travel) {
            (Some(before), Some(now)) => {
                let [left, right] = [0, 1].map(|wheel| now[wheel] - before[wheel]);
                (right - left) / (TAU * self.base_mm)
            }
            _ => self.turned + self.rate * moment.at.saturating_sub(self.since).as_secs_f64(),
        }
    }

    /// Turns on the spot with this speed of the right wheel, mm/s, until `is_over` is true of a moment and of how far the
    /// robot has turned then.
    ///
    /// # Errors
    /// Those of the robot; it has not turned `limit` turns in twice the time that they take.
    fn sweep(
        &mut self,
        vehicle: &mut dyn Vehicle,
        mm_s: f64,
        limit: f64,
        stop: &AtomicBool,
        mut is_over: impl FnMut(&Moment, f64) -> bool,
    ) -> Result {
        vehicle.drive([-mm_s, mm_s])?;
        self.since = vehicle.now();
        self.rate = 2.0 * mm_s / (TAU * self.base_mm);
        let end = self.since + Duration::from_secs_f64(2.0 * limit / self.rate.abs() + 2.0);
        let over = loop {
            heed(vehicle, stop)?;
            let moment = vehicle.look()?;
            let turned = self.turned(&moment);
            if is_over(&moment, turned) {
                break turned;
            }
            if vehicle.now() > end {
                vehicle.stop()?;
                let problem = "its wheels have turned less than half as far as commanded: is it stuck?";
                return Err(Trouble::Displaced(problem.into()));
            }
            vehicle.keep_until(vehicle.now())?;
        };
        vehicle.stop()?;
        (self.turned, self.rate) = (over, 0.0);
        Ok(())
    }

    /// Turns back until its angle is at most this.
    fn back(&mut self, vehicle: &mut dyn Vehicle, to: f64, mm_s: f64, stop: &AtomicBool) -> Result {
        self.sweep(vehicle, -mm_s, 1.0, stop, |_, turned| turned <= to)
    }
}

/// Stops the wheels if the user has stopped the program.
fn heed(vehicle: &mut dyn Vehicle, stop: &AtomicBool) -> Result {
    if stop.load(Ordering::Relaxed) {
        vehicle.stop()?;
        return Err(Trouble::Stopped);
    }
    Ok(())
}

/// Readings as integers from 0 to 1023: fractions of each sensor's range.
fn scaled(profile: &Profile, moment: &Moment) -> Vec<u16> {
    let ranges = profile
        .sensors
        .iter()
        .flat_map(|sensors| sensors.names.iter().map(|_| sensors.range));
    let share = |((low, high), reading): ((f64, f64), &f64)| ((reading - low) / (high - low)).clamp(0.0, 1.0);
    let shares = ranges.zip(&moment.readings).map(share);
    shares
        .map(|share| (f64::from(GREATEST_READING) * share).round() as u16)
        .collect()
}

/// Speed of the wheels in mm/s at which a robot can be read twice in each bearing's interval, as far as its link and its minimum
/// speed allow. The robot's looks are timed for a while.
///
/// # Errors
/// Those of the robot.
pub fn pace(vehicle: &mut dyn Vehicle) -> Result<f64> {
    const LOOKS: usize = 15;
    /// Some robots update their readings only ten times a second: a bearing's interval in 100 ms.
    const GREATEST_RATE: f64 = 10.0 / BEARINGS as f64;
    let (mut times, mut last) = (Vec::new(), vehicle.look()?.at);
    for _ in 0..LOOKS {
        let at = vehicle.look()?.at;
        times.push(at.saturating_sub(last).as_secs_f64());
        last = at;
    }
    times.sort_unstable_by(f64::total_cmp);
    let rate = 0.5 / (f64::from(BEARINGS) * times[LOOKS / 2].max(1e-3));
    let profile = vehicle.profile();
    let mm_s = 0.5 * TAU * profile.base_mm * rate.min(GREATEST_RATE);
    let units = (mm_s.min(profile.greatest_mm_s) / profile.unit_mm_s).floor().max(1.0);
    Ok(units * profile.unit_mm_s)
}

/// Measures how a robot turns, from a little over three turns with these speeds of its wheels before an object that it senses
/// well. It has its heading again at the end.
///
/// # Errors
/// Those of the robot; it senses nothing in which a whole turn can be recognised.
pub fn measured(vehicle: &mut dyn Vehicle, wheel_mm_s: f64, stop: &AtomicBool) -> Result<Turning> {
    let mut compass = Compass::new(vehicle)?;
    let signal = swept(vehicle, &mut compass, wheel_mm_s, MEASURED, stop, |_, turned| {
        turned >= MEASURED
    })?;
    let apparent = signal.period().ok_or_else(|| {
        let problem = "in three turns no whole turn can be recognised from its sensors; it must stand before an object, \
                       with nothing else near it";
        Trouble::Displaced(problem.into())
    })?;
    let whole = (compass.turned / apparent).floor() * apparent;
    compass.back(vehicle, whole, wheel_mm_s, stop)?;
    Ok(Turning { wheel_mm_s, apparent })
}

/// Turns, and takes readings by how far the robot has turned.
fn swept(
    vehicle: &mut dyn Vehicle,
    compass: &mut Compass,
    mm_s: f64,
    limit: f64,
    stop: &AtomicBool,
    mut is_over: impl FnMut(&Signal, f64) -> bool,
) -> Result<Signal> {
    let mut signal = Signal::default();
    let profile = vehicle.profile().clone();
    compass.sweep(vehicle, mm_s, limit, stop, |moment, turned| {
        signal.push(turned, scaled(&profile, moment));
        is_over(&signal, turned)
    })?;
    Ok(signal)
}

/// Turns a robot counter-clockwise before a single object straight ahead of it: as many times as requested, a part of a turn
/// beyond that, and up to two turns more if there are bearings without a reading. It has its heading again at the end.
///
/// # Errors
/// Those of the robot; it can't be read at each bearing.
pub fn turn_before(vehicle: &mut dyn Vehicle, turning: Turning, turns: u32, stop: &AtomicBool) -> Result<Turn> {
    let Turning { wheel_mm_s, apparent } = turning;
    let mut compass = Compass::new(vehicle)?;
    let ends = |turns: u32| f64::from(turns) + OVERLAP;
    let most = ends(turns + MORE_TURNS);
    let complete = |signal: &Signal| {
        let turn = Turn {
            signal: signal.scaled(apparent),
            turns,
            overlap: Overlap::Blank,
        };
        turn.row().is_ok()
    };
    let mut goal = ends(turns);
    let signal = swept(vehicle, &mut compass, wheel_mm_s, most, stop, |signal, turned| {
        if turned < goal * apparent {
            return false;
        }
        // Looked at once a turn.
        goal += 1.0;
        goal > most || complete(signal)
    })?;
    let whole = (compass.turned / apparent).floor() * apparent;
    compass.back(vehicle, whole, wheel_mm_s, stop)?;
    let signal = signal.scaled(apparent);
    let overlap = signal.overlap(turns, OVERLAP, MOST_DRIFT);
    let turn = Turn { signal, turns, overlap };
    match turn.row() {
        Ok(_) => Ok(turn),
        Err(bearing) => {
            let low = f64::from(bearing) * 360.0 / f64::from(BEARINGS);
            Err(Trouble::Unreadable(format!(
                "there is no reading between {low} and {} degrees after {} turns at its slowest; its link is too slow",
                low + 360.0 / f64::from(BEARINGS),
                turns + MORE_TURNS
            )))
        }
    }
}

/// Drives in the open with a pair of speeds, from -10 to 10 tenths of `full_mm_s`, measures the motion by the odometers, and
/// drives back for as long. `apparent` is as in [`Turning`]: turns by the wheels are divided by it.
///
/// # Errors
/// Those of the robot; it has no odometers.
pub fn drive(
    vehicle: &mut dyn Vehicle,
    (left, right): (i32, i32),
    full_mm_s: f64,
    apparent: f64,
    stop: &AtomicBool,
) -> Result<Driven> {
    let speeds = [left, right].map(|speed| f64::from(speed) / 10.0 * full_mm_s);
    vehicle.drive(speeds)?;
    let start = vehicle.now();
    wait(vehicle, start + REACHED, stop)?;
    let before = vehicle.look()?;
    wait(vehicle, before.at + DRIVEN, stop)?;
    let after = vehicle.look()?;
    let lasted = vehicle.now().saturating_sub(start);
    vehicle.drive(speeds.map(|speed| 0.0 - speed))?;
    let back = vehicle.now();
    wait(vehicle, back + lasted, stop)?;
    vehicle.stop()?;
    let (Some(from), Some(to)) = (before.travel, after.travel) else {
        return Err(Trouble::Broken(format!(
            "the {} has no odometers",
            vehicle.profile().robot
        )));
    };
    let cycles = after.at.saturating_sub(before.at).as_secs_f64() / 0.1;
    let [left, right] = [0, 1].map(|wheel| (to[wheel] - from[wheel]) / cycles);
    Ok(Driven {
        displacement: 0.5 * (left + right),
        turn: (right - left) / (TAU * vehicle.profile().base_mm * apparent),
    })
}

/// After this time the wheels have their commanded speeds, also within the guard's acceleration.
const REACHED: Duration = Duration::from_millis(600);
/// Duration of a motion's measurement.
const DRIVEN: Duration = Duration::from_secs(1);

/// Duration of a pair of speeds there and back, s.
pub fn seconds_a_pair() -> f64 {
    2.0 * (REACHED + DRIVEN).as_secs_f64()
}

/// Maximum distance of a robot from its place when it drives with a pair of speeds up to `full_mm_s`, mm.
pub fn reach_mm(full_mm_s: f64) -> f64 {
    full_mm_s * (REACHED + DRIVEN).as_secs_f64()
}

/// Keeps the speeds until a moment.
fn wait(vehicle: &mut dyn Vehicle, until: Duration, stop: &AtomicBool) -> Result {
    const GLANCE: Duration = Duration::from_millis(100);
    while vehicle.now() < until {
        heed(vehicle, stop)?;
        vehicle.keep_until(until.min(vehicle.now() + GLANCE))?;
    }
    heed(vehicle, stop)
}

#[cfg(test)]
mod tests;
