//! Khepera and Khepera II, over a serial line.
//!
//! Commands are those of appendix A of the user manual (K-Team, 1999), as its clients send them: Player's driver, kMatlab
//! and RoadNarrows' `KheCmdBase`. The robot has no time-out: it keeps its last speed.

use std::fmt::Write;
use std::time::Duration;

use super::error::{Error, Result};
use super::link::Link;
use super::talk::{self, Stepped, Talk, persistently};
use super::{Battery, Description, Group, Kind, Odometry, Reading, Robot, Unwrapped, Wheels};

/// In the lines that the robot sends when it starts (K-Team, "Khepera II FAQ").
const BANNER: &str = "ROM of minirobot KHEPERA";
/// Over a cable. The longest answer takes 52 ms at 9600 baud, and Player's driver waits 100 ms.
const PATIENCE: Duration = Duration::from_millis(150);
/// Between two bytes of one answer there are 1.2 ms at 9600 baud, and up to 16 ms in an adapter to USB.
const SILENCE: Duration = Duration::from_millis(50);
/// How long the wheels may take to stand still after a stop.
const STANDSTILL: Duration = Duration::from_millis(200);
/// Ends what was half sent, and stops.
const STOP: &str = "\rD,0,0\r";
/// A command that can be repeated is tried as often as this.
const TRIES: u32 = 3;

/// Infra-red sensors in the order of the answers to `N` and `O`: clockwise from the left.
const PROXIMITY: Group = Group {
    kind: Kind::Proximity,
    names: &[
        "proximity_left_90",
        "proximity_left_45",
        "proximity_left_10",
        "proximity_right_10",
        "proximity_right_45",
        "proximity_right_90",
        "proximity_back_right",
        "proximity_back_left",
    ],
    unit: "",
    range: (0.0, 1023.0),
};
const LIGHT: Group = Group {
    kind: Kind::Light,
    names: &[
        "light_left_90",
        "light_left_45",
        "light_left_10",
        "light_right_10",
        "light_right_45",
        "light_right_90",
        "light_back_right",
        "light_back_left",
    ],
    ..PROXIMITY
};
const WHEEL_SPEED: Group = Group {
    kind: Kind::WheelSpeed,
    names: &["wheel_speed_left", "wheel_speed_right"],
    unit: WHEELS.unit,
    range: (-255.0, 255.0),
};
/// The limit is RoadNarrows'. A pulse is 1/12 mm (Player, kMatlab), but a unit of speed was measured as 8.2 mm/s, not 8.33
/// (KiKS, and the motor tables of Evorobot).
const WHEELS: Wheels = Wheels {
    unit: "pulses / 10 ms",
    greatest: 127,
    mm_s: 8.2,
    base_mm: 53.0,
    mm_per_count: Some(1.0 / 12.0),
};

/// A command, with pairs of arguments for the left and the right wheel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Command {
    /// `A`: gains of the speed controller: proportional, integral, derivative. Default 3800, 800, 100.
    SpeedGains([i32; 3]),
    /// `B`: versions of the BIOS and of the protocol.
    Version,
    /// `C`: goes to positions, pulses.
    GoTo([i32; 2]),
    /// `D`: sets speeds, pulses / 10 ms.
    Drive([i32; 2]),
    /// `E`: measured speeds, pulses / 10 ms.
    Speeds,
    /// `F`: gains of the position controller. Default 3000, 20, 4000.
    PositionGains([i32; 3]),
    /// `G`: sets the position counters, pulses.
    SetPositions([i32; 2]),
    /// `H`: position counters, pulses.
    Positions,
    /// `I`: an analogue input, channel 0 to 5: 10 bits, 0 to 4.096 V. Channels 3 to 5 are free.
    Analogue(u8),
    /// `J`: speed and acceleration of `GoTo` for each wheel. Default 20 and 64.
    Profile([i32; 4]),
    /// `K`: for each wheel, whether it has arrived (1), its mode (1 for speed control) and its error.
    Status,
    /// `L`: a light, 0 or 1, and what to do: 0 off, 1 on, 2 toggle.
    Light(u8, u8),
    /// `N`: proximity sensors.
    Proximity,
    /// `O`: ambient light sensors.
    Ambient,
    /// `P`: pulse widths of the motors, -255 to 255, without control.
    PulseWidths([i32; 2]),
    /// `R`: a byte from the extension bus, address 0 to 63.
    ReadBus(u8),
    /// `T`: a text to a turret, by its number.
    Turret(u8, String),
    /// `W`: a byte to the extension bus, address 0 to 63.
    WriteBus {
        /// The byte.
        byte: u8,
        /// Where it goes.
        address: u8,
    },
}

/// The answer to a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Of `B` and `T`, whose fields are text: what follows the letter.
    Text(String),
    /// Of the others.
    Numbers(Vec<i64>),
}

impl Command {
    /// What is sent. Clients end a command with CR (K-Team) or LF (Player).
    pub(crate) fn line(&self) -> String {
        let with = |letter: &str, arguments: &[i32]| {
            arguments.iter().fold(letter.to_owned(), |mut line, argument| {
                // Writing to a string can't fail.
                let _ = write!(line, ",{argument}");
                line
            })
        };
        let line = match self {
            Self::SpeedGains(gains) => with("A", gains),
            Self::Version => "B".into(),
            Self::GoTo(positions) => with("C", positions),
            Self::Drive(speeds) => with("D", speeds),
            Self::Speeds => "E".into(),
            Self::PositionGains(gains) => with("F", gains),
            Self::SetPositions(positions) => with("G", positions),
            Self::Positions => "H".into(),
            Self::Analogue(channel) => with("I", &[i32::from(*channel)]),
            Self::Profile(profile) => with("J", profile),
            Self::Status => "K".into(),
            Self::Light(light, action) => with("L", &[i32::from(*light), i32::from(*action)]),
            Self::Proximity => "N".into(),
            Self::Ambient => "O".into(),
            Self::PulseWidths(widths) => with("P", widths),
            Self::ReadBus(address) => with("R", &[i32::from(*address)]),
            Self::Turret(turret, text) => format!("T,{turret},{text}"),
            Self::WriteBus { byte, address } => with("W", &[i32::from(*byte), i32::from(*address)]),
        };
        line + "\r"
    }

    /// How many numbers are answered, and their range; none if the answer is text.
    fn numbers(&self) -> Option<(usize, (i64, i64))> {
        let any = talk::ANY;
        let of = |group: Group| (group.names.len(), (group.range.0 as i64, group.range.1 as i64));
        Some(match self {
            Self::Version | Self::Turret(..) => return None,
            Self::Speeds => of(WHEEL_SPEED),
            Self::Positions => (2, any),
            Self::Analogue(_) => (1, (0, 1023)),
            Self::Status => (6, any),
            Self::Proximity => of(PROXIMITY),
            Self::Ambient => of(LIGHT),
            Self::ReadBus(_) => (1, (0, 255)),
            _ => (0, any),
        })
    }

    /// Whether it does no more when it is done twice.
    fn repeatable(&self) -> bool {
        !matches!(self, Self::SetPositions(_) | Self::Light(_, 2) | Self::Turret(..))
    }

    /// The answer that a line holds.
    ///
    /// # Errors
    /// The robot refuses, or the line is no answer to this.
    pub(crate) fn parse(&self, line: &str) -> Result<Answer> {
        let command = self.line();
        let Some((count, range)) = self.numbers() else {
            return match &talk::fields(&command, line)?[..] {
                [] => Err(talk::garbage(&command, line)),
                fields => Ok(Answer::Text(fields.join(","))),
            };
        };
        talk::numbers(&command, line, &[count], range).map(Answer::Numbers)
    }
}

/// A Khepera.
pub struct Khepera {
    talk: Talk,
    description: Description,
    /// Speeds that were commanded last.
    speeds: [i32; 2],
    pulses: Unwrapped<32>,
}

impl Khepera {
    /// A robot at the end of a link, which is not asked yet.
    pub fn new(link: Box<dyn Link>) -> Self {
        Self {
            talk: Talk::new(link, BANNER, PATIENCE),
            description: Description {
                robot: "Khepera".into(),
                firmware: String::new(),
                sensors: vec![PROXIMITY, LIGHT, WHEEL_SPEED],
                wheels: WHEELS,
                lights: &["led_0", "led_1"],
            },
            speeds: [0; 2],
            pulses: Unwrapped::default(),
        }
    }

    /// Stops what is there, makes sure that it is a Khepera, and has the stop confirmed.
    ///
    /// # Errors
    /// None answers.
    pub fn begin(&mut self) -> Result {
        self.speeds = [0; 2];
        self.pulses = Unwrapped::default();
        talk::afresh(self)?;
        self.stop()
    }

    /// Whether a Khepera has answered, ever.
    pub(crate) fn has_answered(&self) -> bool {
        !self.description.firmware.is_empty()
    }

    /// Sends a command and returns the answer. A command that fails is repeated, unless that could do it twice.
    ///
    /// # Errors
    /// The robot refuses or has restarted, or the link fails.
    pub fn command(&mut self, command: &Command) -> Result<Answer> {
        let tries = if command.repeatable() { TRIES } else { 1 };
        let outcome = persistently(self, tries, |robot| {
            robot.talk.send(command.line().as_bytes())?;
            robot.answer(command)
        });
        if matches!(outcome, Err(Error::Restarted)) {
            self.speeds = [0; 2];
            self.pulses = Unwrapped::default();
        }
        outcome
    }

    fn answer(&mut self, command: &Command) -> Result<Answer> {
        command.parse(&self.talk.line(&command.line())?)
    }

    fn numbers(&mut self, command: &Command) -> Result<Vec<i64>> {
        Ok(match self.command(command)? {
            Answer::Numbers(numbers) => numbers,
            Answer::Text(_) => Vec::new(),
        })
    }
}

impl Stepped for Khepera {
    fn in_step(&mut self) -> &mut bool {
        self.talk.in_step()
    }

    /// Ends a half-sent command, waits for silence, and asks for the version. Where the wheels should stand, a stop comes
    /// before all that: it must also reach a robot whose answers don't arrive.
    fn resynchronise(&mut self) -> Result {
        let stop = if self.speeds == [0; 2] { STOP } else { "\r" };
        self.talk.send(stop.as_bytes())?;
        self.description.firmware = self.talk.meet(&Command::Version.line(), SILENCE)?.join(",");
        Ok(())
    }
}

impl Robot for Khepera {
    fn description(&self) -> &Description {
        &self.description
    }

    fn halt(&self) -> Vec<u8> {
        STOP.as_bytes().into()
    }

    fn sense(&mut self, kinds: &[Kind]) -> Result<Reading> {
        let start = self.talk.now();
        let mut values = Vec::new();
        for group in self.description.groups(kinds)? {
            let command = match group.kind {
                Kind::Proximity => Command::Proximity,
                Kind::Light => Command::Ambient,
                _ => Command::Speeds,
            };
            values.extend(self.numbers(&command)?.into_iter().map(|value| value as f64));
        }
        let at = self.talk.now();
        let age = at.saturating_sub(start);
        Ok(Reading { at, age, values })
    }

    fn drive(&mut self, left: i32, right: i32) -> Result {
        self.speeds = [left, right].map(|speed| speed.clamp(-WHEELS.greatest, WHEELS.greatest));
        self.command(&Command::Drive(self.speeds)).map(|_| ())
    }

    /// The measured speeds must also be 0: the protocol has no check, so a command with a wrong digit is answered like
    /// the right one.
    fn stop(&mut self) -> Result {
        let until = self.talk.now() + STANDSTILL;
        loop {
            self.drive(0, 0)?;
            let speeds = self.numbers(&Command::Speeds)?;
            if speeds == [0, 0] {
                return Ok(());
            }
            if self.talk.now() >= until {
                return Err(Error::StillTurning {
                    seen: format!("its speeds are {speeds:?}"),
                });
            }
        }
    }

    fn light(&mut self, light: usize, on: bool) -> Result {
        self.description.light(light)?;
        self.command(&Command::Light(light as u8, u8::from(on))).map(|_| ())
    }

    fn battery(&mut self) -> Result<Battery> {
        Err(self.description.lacks("reading of its battery", "none"))
    }

    fn odometry(&mut self) -> Result<Odometry> {
        let start = self.talk.now();
        let counts = self.numbers(&Command::Positions)?;
        let at = self.talk.now();
        Ok(Odometry {
            at,
            age: at.saturating_sub(start),
            counts: self.pulses.next([counts[0], counts[1]]),
        })
    }

    fn reconnect(&mut self) -> Result {
        self.talk.link().reopen()?;
        self.begin()
    }
}

#[cfg(test)]
pub(super) mod tests;
