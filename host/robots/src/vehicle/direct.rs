//! A vehicle without a guard: a driver in this process, on a virtual clock. For tests.

use std::time::Duration;

use super::trouble::Trouble;
use super::{Moment, Profile, Vehicle};
use crate::error::{Error, Result};
use crate::guard::message;
use crate::link::Clock;
use crate::{Kind, Robot};

/// A clock that can be advanced.
pub trait Hand: Clock {
    /// Lets time pass until a moment, which may have passed.
    fn pass_until(&mut self, until: Duration);
}

/// A driver whose link has the clock.
pub struct Direct<H> {
    robot: Box<dyn Robot>,
    clock: H,
    kinds: Vec<Kind>,
    profile: Profile,
}

impl<H: Hand> Direct<H> {
    /// A robot that is connected, and the sensors that are read.
    pub fn new(robot: Box<dyn Robot>, clock: H, kinds: &[Kind]) -> Self {
        let description = robot.description();
        let wheels = description.wheels;
        let profile = Profile {
            robot: description.robot.clone(),
            firmware: description.firmware.clone(),
            sensors: message::sensors(description, kinds),
            greatest_mm_s: f64::from(wheels.greatest) * wheels.mm_s,
            unit_mm_s: wheels.mm_s,
            base_mm: wheels.base_mm,
            has_odometers: wheels.mm_per_count.is_some(),
        };
        Self {
            robot,
            clock,
            kinds: kinds.to_vec(),
            profile,
        }
    }
}

/// A driver's failure as trouble for the episode or the sampling.
fn trouble(error: &Error) -> Trouble {
    match error {
        Error::Restarted => Trouble::Displaced(error.to_string()),
        error if error.may_pass() => Trouble::Unreadable(error.to_string()),
        error => Trouble::Broken(error.to_string()),
    }
}

impl<H: Hand> Vehicle for Direct<H> {
    fn profile(&self) -> &Profile {
        &self.profile
    }

    fn now(&self) -> Duration {
        self.clock.now()
    }

    fn look(&mut self) -> std::result::Result<Moment, Trouble> {
        let start = self.clock.now();
        let mut look = || -> Result<Moment> {
            let reading = self.robot.sense(&self.kinds)?;
            let first = reading.at.saturating_sub(reading.age).min(start);
            let wheels = self.robot.description().wheels;
            let (at, travel) = match wheels.mm_per_count {
                None => (reading.at, None),
                Some(mm) => {
                    let odometry = self.robot.odometry()?;
                    (odometry.at, Some(odometry.counts.map(|count| count as f64 * mm)))
                }
            };
            Ok(Moment {
                at,
                age: at.saturating_sub(first),
                readings: reading.values,
                travel,
            })
        };
        look().map_err(|error| trouble(&error))
    }

    fn drive(&mut self, [left, right]: [f64; 2]) -> std::result::Result<(), Trouble> {
        self.robot.drive_mm_s(left, right).map_err(|error| trouble(&error))
    }

    fn keep_until(&mut self, until: Duration) -> std::result::Result<(), Trouble> {
        self.clock.pass_until(until);
        Ok(())
    }

    fn stop(&mut self) -> std::result::Result<(), Trouble> {
        self.robot.stop().map_err(|error| trouble(&error))
    }

    fn recover(&mut self) -> std::result::Result<(), Trouble> {
        match self.robot.stop() {
            // A restart is reported once.
            Err(Error::Restarted) => self.stop(),
            outcome => outcome.map_err(|error| trouble(&error)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::khepera::Khepera;
    use crate::khepera::tests::opening;
    use crate::script::{Scripted, Step, hear, say};

    #[test]
    fn a_driver_is_looked_at_and_driven_on_its_clock() {
        let exchange = |line: &str, answer: &str| [hear(format!("{line}\r")), say(format!("{answer}\r\n"))];
        let steps: Vec<Step> = [
            exchange("N", "n,1,2,3,4,5,6,7,1023"),
            exchange("H", "h,12,-24"),
            exchange("D,2,-1", "d"),
            exchange("D,0,0", "d"),
            exchange("E", "e,0,0"),
            [hear("N\r"), say("\r\nROM of minirobot KHEPERA\r\n")],
        ]
        .concat();
        let link = Scripted::new(opening().into_iter().chain(steps));
        let clock = link.hand();
        let mut robot = Khepera::new(Box::new(link));
        robot.begin().unwrap();
        let mut vehicle = Direct::new(Box::new(robot), clock, &[Kind::Proximity]);
        assert_eq!(vehicle.profile().robot, "Khepera");
        assert_eq!(vehicle.profile().sensors[0].names.len(), 8);
        let moment = vehicle.look().unwrap();
        assert_eq!(moment.readings, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 1023.0]);
        assert_eq!(moment.travel, Some([1.0, -2.0]));
        assert_eq!((moment.at, moment.age), (vehicle.now(), Duration::from_millis(20)));
        vehicle.drive([16.0, -8.2]).unwrap();
        let until = vehicle.now() + Duration::from_secs(2);
        vehicle.keep_until(until).unwrap();
        assert_eq!(vehicle.now(), until);
        vehicle.keep_until(Duration::ZERO).unwrap();
        assert_eq!(vehicle.now(), until);
        vehicle.stop().unwrap();
        assert!(matches!(vehicle.look(), Err(Trouble::Displaced(_))));
    }
}
