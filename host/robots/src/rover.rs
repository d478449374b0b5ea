//! A robot that nobody has built, and its driver, the smallest one: it shows what a driver needs. For tests.

use std::time::Duration;

use super::driver::{Driver, Met, Reach};
use super::error::Result;
use super::link::Link;
use super::talk::{self, Stepped, Talk, persistently};
use super::{Battery, Description, Group, Kind, Odometry, Reading, Robot, Wheels};

pub(super) const DRIVER: Driver = Driver {
    robots: &["Rover"],
    reach: Reach::Serial {
        bauds: &[BAUD],
        ask: |link| {
            let mut robot = Rover::new(link);
            let begun = robot.begin();
            let has_answered = !robot.description.firmware.is_empty();
            Met::of(robot, begun, has_answered, |robot| robot.talk.into_link())
        },
    },
};
pub(super) const BAUD: u32 = 250_000;
const DISTANCE: Group = Group {
    kind: Kind::Distance,
    names: &["distance_front"],
    unit: "mm",
    range: (0.0, 2000.0),
};

struct Rover {
    talk: Talk,
    description: Description,
}

impl Rover {
    fn new(link: Box<dyn Link>) -> Self {
        Self {
            talk: Talk::new(link, "Rover is ready", Duration::from_millis(100)),
            description: Description {
                robot: "Rover".into(),
                firmware: String::new(),
                sensors: vec![DISTANCE],
                wheels: Wheels {
                    unit: "cm / s",
                    greatest: 50,
                    mm_s: 10.0,
                    base_mm: 200.0,
                    mm_per_count: None,
                },
                lights: &[],
            },
        }
    }

    fn begin(&mut self) -> Result {
        talk::afresh(self)?;
        self.stop()
    }

    /// Sends a line, and returns the numbers of the answer.
    fn numbers(&mut self, line: &str, count: usize) -> Result<Vec<i64>> {
        persistently(self, 3, |robot| {
            robot.talk.send(line.as_bytes())?;
            talk::numbers(line, &robot.talk.line(line)?, &[count], talk::ANY)
        })
    }
}

impl Stepped for Rover {
    fn in_step(&mut self) -> &mut bool {
        self.talk.in_step()
    }

    fn resynchronise(&mut self) -> Result {
        self.description.firmware = self.talk.meet("Y\r", Duration::from_millis(20))?.join(",");
        Ok(())
    }
}

impl Robot for Rover {
    fn description(&self) -> &Description {
        &self.description
    }

    fn sense(&mut self, kinds: &[Kind]) -> Result<Reading> {
        self.description.groups(kinds)?;
        let start = self.talk.now();
        let values = self.numbers("X\r", 1)?.into_iter().map(|mm| mm as f64).collect();
        let at = self.talk.now();
        Ok(Reading {
            at,
            age: at.saturating_sub(start),
            values,
        })
    }

    fn drive(&mut self, left: i32, right: i32) -> Result {
        self.numbers(&format!("D,{left},{right}\r"), 0).map(drop)
    }

    fn stop(&mut self) -> Result {
        self.drive(0, 0)
    }

    fn halt(&self) -> Vec<u8> {
        b"\rD,0,0\r".into()
    }

    fn light(&mut self, light: usize, _: bool) -> Result {
        self.description.light(light)
    }

    fn battery(&mut self) -> Result<Battery> {
        Err(self.description.lacks("reading of its battery", "none"))
    }

    fn odometry(&mut self) -> Result<Odometry> {
        Err(self.description.lacks("odometers", "none"))
    }

    fn reconnect(&mut self) -> Result {
        self.talk.link().reopen()?;
        self.begin()
    }
}

pub(super) mod tests {
    use std::sync::{Arc, Mutex};

    /// What the robot answers to what it has received, of which it takes whole lines, and the speeds of its wheels.
    pub(crate) fn robot(wheels: Arc<Mutex<Vec<[i32; 2]>>>) -> impl Fn(&mut Vec<u8>) -> Vec<u8> {
        move |received| {
            let Some(end) = received.iter().position(|byte| *byte == b'\r') else {
                return Vec::new();
            };
            let line: Vec<u8> = received.drain(..=end).collect();
            let line = str::from_utf8(&line[..end]).unwrap_or_default();
            let speeds = line.strip_prefix("D,").and_then(|speeds| speeds.split_once(','));
            let answer = match (line, speeds) {
                ("Y", _) => "y,Rover 1\r\n",
                ("X", _) => "x,120\r\n",
                (_, Some((left, right))) => {
                    let speeds = [left, right].map(|speed| speed.parse().unwrap());
                    wheels.lock().unwrap().push(speeds);
                    "d\r\n"
                }
                _ => "z,Unknown\r\n",
            };
            answer.into()
        }
    }
}
