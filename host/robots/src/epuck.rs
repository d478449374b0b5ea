//! e-puck 1.x and e-puck2 over a serial line: Bluetooth, USB, or an extension board's UART.
//!
//! Both speak `SerCom`, as text and in binary (GCtronic, DemoGCtronic-complete/Asercom.c; e-puck2 main processor,
//! Asercom2.c). A binary message is a chain of commands, each the negative of a letter, ended by 0; the answers come
//! together, in order. Here every chain ends by asking for the commanded speeds, which are known: an answer that is out
//! of step, or of a robot that has restarted or obeys a remote control, shows itself. Some old firmware has text only.
//!
//! The robot has no time-out: it keeps its last speed.

use std::time::Duration;

use super::error::{Error, Result};
use super::link::Link;
use super::talk::{self, Stepped, Talk, garbage, persistently};
use super::{Battery, Description, Group, Kind, Odometry, Reading, Robot, Unwrapped, Wheels, is_tilted};

/// In the lines that the robot sends when it starts, after a form feed and a bell.
const BANNER: &str = "WELCOME to the SerCom protocol";
/// Over a cable, or over a port that may be Bluetooth without the system reporting it: Bluetooth delays single answers by some
/// 100 ms.
const PATIENCE: Duration = Duration::from_millis(500);
const SILENCE: Duration = Duration::from_millis(60);
const TRIES: u32 = 3;
/// An e-puck of version 1.3 reports its charge in percent. Our own limit.
const LOW_PERCENT: u8 = 10;
/// As many zeros as the longest binary command has arguments, and more: they complete it, and speeds become 0.
const FLUSH: &[u8] = &[0; 21];
const STOP: &str = "D,0,0\r";

/// 1000 steps are a revolution of a wheel of 20.5 mm radius. An e-puck obeys up to 1000 steps/s, an e-puck2 up to 1100.
pub(super) const WHEELS: Wheels = Wheels {
    unit: "steps / s",
    greatest: 1000,
    mm_s: 0.128_8,
    base_mm: 53.0,
    mm_per_count: Some(0.128_8),
};
/// Clockwise from the front right, named as in the preset `epuck`. 12 bits, less the ambient light, and not below 0.
pub(super) const PROXIMITY: Group = Group {
    kind: Kind::Proximity,
    names: &[
        "prox_0", "prox_1", "prox_2", "prox_3", "prox_4", "prox_5", "prox_6", "prox_7",
    ],
    unit: "",
    range: (0.0, 4095.0),
};
pub(super) const LIGHT: Group = Group {
    kind: Kind::Light,
    names: &[
        "light_0", "light_1", "light_2", "light_3", "light_4", "light_5", "light_6", "light_7",
    ],
    ..PROXIMITY
};
pub(super) const ACCELERATION: Group = Group {
    kind: Kind::Acceleration,
    names: &["acceleration_x", "acceleration_y", "acceleration_z"],
    unit: "",
    range: (-32_768.0, 32_767.0),
};
/// 250 degrees/s are 32,768.
pub(super) const ROTATION: Group = Group {
    kind: Kind::Rotation,
    names: &["rotation_x", "rotation_y", "rotation_z"],
    unit: "",
    range: (-32_768.0, 32_767.0),
};
/// The maximum of some samples minus the minimum: of 12 bits in an e-puck, of 16 in an e-puck2.
pub(super) const SOUND: Group = Group {
    kind: Kind::Sound,
    names: &["sound_0", "sound_1", "sound_2"],
    unit: "",
    range: (0.0, 65_535.0),
};
pub(super) const GROUND: Group = Group {
    kind: Kind::Ground,
    names: &["ground_left", "ground_centre", "ground_right"],
    unit: "",
    range: (0.0, 65_535.0),
};
pub(super) const DISTANCE: Group = Group {
    kind: Kind::Distance,
    names: &["distance_front"],
    unit: "mm",
    range: (0.0, 65_535.0),
};
pub(super) const LIGHTS: &[&str] = &[
    "led_1", "led_2", "led_3", "led_4", "led_5", "led_6", "led_7", "led_8", "body", "front",
];

/// How sensors are asked for.
struct Source {
    group: Group,
    /// In text.
    letter: Option<char>,
    /// In binary; the negative is sent.
    code: u8,
    /// Numbers answered, of which the first are the sensors'. Of infra-red sensors there may be more.
    words: usize,
}

const fn source(group: Group, letter: Option<char>, code: u8, words: usize) -> Source {
    Source {
        group,
        letter,
        code,
        words,
    }
}

/// Sources without a letter are the e-puck2's. The floor's last value is a cliff sensor's.
const SOURCES: [Source; 7] = [
    source(PROXIMITY, Some('N'), b'N', 8),
    source(LIGHT, Some('O'), b'O', 8),
    source(ACCELERATION, Some('A'), b'a', 3),
    source(SOUND, Some('U'), b'u', 3),
    source(ROTATION, None, b'g', 3),
    source(GROUND, None, b'M', 4),
    source(DISTANCE, None, 0x0d, 1),
];

/// What the firmware understands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Dialect {
    Text,
    Binary,
}

/// An e-puck or an e-puck2.
pub(crate) struct EPuck {
    talk: Talk,
    description: Description,
    dialect: Dialect,
    /// Numbers in an answer to `N` or `O`: 8, or 10 over the UART of the extension board.
    infrared: usize,
    /// Speeds that were commanded last.
    speeds: [i16; 2],
    steps: Unwrapped<16>,
}

impl EPuck {
    /// A robot at the end of a link, which is not asked yet.
    pub(crate) fn new(link: Box<dyn Link>) -> Self {
        Self {
            talk: Talk::new(link, BANNER, PATIENCE),
            description: Description {
                robot: "e-puck".into(),
                firmware: String::new(),
                sensors: Vec::new(),
                wheels: WHEELS,
                lights: LIGHTS,
            },
            dialect: Dialect::Text,
            infrared: PROXIMITY.names.len(),
            speeds: [0; 2],
            steps: Unwrapped::default(),
        }
    }

    /// Gives the link back.
    pub(crate) fn into_link(self) -> Box<dyn Link> {
        self.talk.into_link()
    }

    /// Stops what is there, makes sure that it is an e-puck, has the stop confirmed, and finds out what the firmware
    /// understands.
    ///
    /// # Errors
    /// None answers.
    pub(crate) fn begin(&mut self) -> Result {
        self.speeds = [0; 2];
        self.steps = Unwrapped::default();
        talk::afresh(self)?;
        self.stop()?;
        self.infrared = self.numbers("N\r", &[8, 10])?.len();
        self.dialect = match self.persistently(|robot| robot.chain("Q", &[negative(b'Q')], 2)) {
            Ok(_) => Dialect::Binary,
            // It still answers in text.
            Err(error) if error.may_pass() && *self.in_step() => Dialect::Text,
            Err(error) => return Err(error),
        };
        self.description.robot = if self.is_2() { "e-puck2" } else { "e-puck" }.into();
        self.description.sensors = self.sources().map(|source| source.group).collect();
        Ok(())
    }

    /// Whether an e-puck has answered, ever.
    pub(crate) fn has_answered(&self) -> bool {
        !self.description.firmware.is_empty()
    }

    /// Whether it is an e-puck2, by its version: "Version 2.0 January 2018 GCtronic".
    fn is_2(&self) -> bool {
        self.description.firmware.contains("Version 2")
    }

    /// Sources that can be used.
    fn sources(&self) -> impl Iterator<Item = &'static Source> + use<> {
        let has_all = self.is_2() && self.dialect == Dialect::Binary;
        SOURCES.iter().filter(move |source| has_all || source.letter.is_some())
    }

    /// How many numbers a source answers.
    fn words(&self, source: &Source) -> usize {
        match source.group.kind {
            Kind::Proximity | Kind::Light => self.infrared,
            _ => source.words,
        }
    }

    fn persistently<T>(&mut self, attempt: impl FnMut(&mut Self) -> Result<T>) -> Result<T> {
        let outcome = persistently(self, TRIES, attempt);
        if matches!(outcome, Err(Error::Restarted)) {
            self.steps = Unwrapped::default();
            self.speeds = [0; 2];
        }
        outcome
    }

    /// Sends a line once and returns the numbers of the answer.
    fn line(&mut self, line: &str, counts: &[usize]) -> Result<Vec<i64>> {
        self.talk.send(line.as_bytes())?;
        talk::numbers(line, &self.talk.line(line)?, counts, talk::ANY)
    }

    /// Sends a line and returns the numbers of the answer.
    fn numbers(&mut self, line: &str, counts: &[usize]) -> Result<Vec<i64>> {
        self.persistently(|robot| robot.line(line, counts))
    }

    /// Sends a chain of commands once and returns the words answered. `name` is for messages.
    fn chain(&mut self, name: &str, commands: &[u8], words: usize) -> Result<Vec<i16>> {
        self.talk.send(&[commands, &[negative(b'E'), 0]].concat())?;
        let answer = self.talk.bytes(name, 2 * (words + 2))?;
        let answer: Vec<i16> = answer
            .as_chunks()
            .0
            .iter()
            .map(|word| i16::from_le_bytes(*word))
            .collect();
        match answer.split_at(words) {
            (answer, speeds) if speeds == self.speeds => Ok(answer.into()),
            (_, speeds) => Err(garbage(
                name,
                &format!(
                    "speeds {speeds:?} and not {:?} after it; a remote control sets them too",
                    self.speeds
                ),
            )),
        }
    }

    /// Sends a command whose answer has no values, in either dialect.
    fn order(&mut self, name: &str, line: &str, chain: &[u8]) -> Result {
        match self.dialect {
            Dialect::Text => self.numbers(line, &[0]).map(|_| ()),
            Dialect::Binary => self.persistently(|robot| robot.chain(name, chain, 0)).map(|_| ()),
        }
    }

    /// Readings in text, one command for each source.
    fn in_text(&mut self, sources: &[&Source]) -> Result<Vec<f64>> {
        let mut values = Vec::new();
        for source in sources {
            let line = source.letter.map(|letter| format!("{letter}\r")).unwrap_or_default();
            values.extend(self.persistently(|robot| {
                let read = robot.line(&line, &[robot.words(source)])?;
                let read = read.into_iter().take(source.group.names.len());
                within(source.group, read.map(|value| value as f64).collect())
            })?);
        }
        Ok(values)
    }

    /// Readings in binary, all in one chain.
    fn in_binary(&mut self, sources: &[&Source]) -> Result<Vec<f64>> {
        let commands: Vec<u8> = sources.iter().map(|source| negative(source.code)).collect();
        self.persistently(|robot| {
            let total = sources.iter().map(|source| robot.words(source)).sum();
            let mut rest = &robot.chain("the sensors", &commands, total)?[..];
            let mut values = Vec::new();
            for source in sources {
                let (answer, next) = rest.split_at(robot.words(source));
                // Some of them have no sign, and 16 bits.
                let number = |word: &i16| match source.group.range.0 {
                    0.0 => f64::from(*word as u16),
                    _ => f64::from(*word),
                };
                let read = answer.iter().take(source.group.names.len()).map(number).collect();
                values.extend(within(source.group, read)?);
                rest = next;
            }
            Ok(values)
        })
    }
}

fn negative(code: u8) -> u8 {
    code.wrapping_neg()
}

/// Readings, if they can be the group's.
fn within(group: Group, values: Vec<f64>) -> Result<Vec<f64>> {
    if group.accepts(&values) {
        Ok(values)
    } else {
        Err(garbage(&format!("{} sensors", group.kind), &format!("{values:?}")))
    }
}

impl Stepped for EPuck {
    fn in_step(&mut self) -> &mut bool {
        self.talk.in_step()
    }

    /// Zeros end a half-sent binary command, and CR a line; then the version is asked for. That must be text: after a
    /// line's end the firmware takes what follows for text, binary or not. Where the wheels should stand, a stop comes
    /// before the question: it must also reach a robot whose answers don't arrive.
    fn resynchronise(&mut self) -> Result {
        let begin = if self.speeds == [0; 2] {
            self.halt()
        } else {
            [FLUSH, b"\r"].concat()
        };
        self.talk.send(&begin)?;
        self.talk.silence(SILENCE)?;
        self.talk.send(b"V\r")?;
        let line = self.talk.line("V")?;
        self.description.firmware = talk::fields("V", &line)?.join(",");
        // A second line has the hardware's version.
        self.talk.silence(SILENCE)
    }
}

impl Robot for EPuck {
    fn description(&self) -> &Description {
        &self.description
    }

    /// The zeros come first: to a half-sent binary command, text would be speeds.
    fn halt(&self) -> Vec<u8> {
        [FLUSH, b"\r", STOP.as_bytes()].concat()
    }

    fn sense(&mut self, kinds: &[Kind]) -> Result<Reading> {
        let start = self.talk.now();
        let groups = self.description.groups(kinds)?;
        let sources: Vec<&Source> = groups
            .iter()
            .filter_map(|group| SOURCES.iter().find(|source| source.group == *group))
            .collect();
        let values = match self.dialect {
            Dialect::Text => self.in_text(&sources)?,
            Dialect::Binary => self.in_binary(&sources)?,
        };
        let at = self.talk.now();
        let age = at.saturating_sub(start);
        Ok(Reading { at, age, values })
    }

    fn drive(&mut self, left: i32, right: i32) -> Result {
        self.speeds = [left, right].map(|speed| speed.clamp(-WHEELS.greatest, WHEELS.greatest) as i16);
        if self.speeds == [0; 2] {
            return self.stop();
        }
        let [left, right] = self.speeds;
        let ([a, b], [c, d]) = (left.to_le_bytes(), right.to_le_bytes());
        self.order(
            "the speeds",
            &format!("D,{left},{right}\r"),
            &[negative(b'D'), a, b, c, d],
        )
    }

    /// In text, whatever the dialect: in binary four zeros would confirm it, and readings of sensors may begin so.
    fn stop(&mut self) -> Result {
        self.speeds = [0; 2];
        self.persistently(|robot| {
            robot.line(STOP, &[0])?;
            match robot.line("E\r", &[2])?[..] {
                [0, 0] => Ok(()),
                ref speeds => Err(Error::StillTurning {
                    seen: format!("its speeds are {speeds:?}"),
                }),
            }
        })
    }

    fn light(&mut self, light: usize, on: bool) -> Result {
        self.description.light(light)?;
        let on = u8::from(on);
        let line = match light {
            8 => format!("B,{on}\r"),
            9 => format!("F,{on}\r"),
            led => format!("L,{led},{on}\r"),
        };
        self.order("a light", &line, &[negative(b'L'), light as u8, on])
    }

    /// Asks in text, which says most: `b,RAW (PERCENT%)`, or before version 1.3 `b,1` if it is charged and `b,0` if not.
    fn battery(&mut self) -> Result<Battery> {
        let told = self.persistently(|robot| {
            robot.talk.send(b"b\r")?;
            battery(&robot.talk.line("b")?)
        })?;
        Ok(match told {
            Charge::Flag(ok) => Battery { volts: None, low: !ok },
            Charge::Raw { raw, .. } if self.is_2() => charge(raw),
            Charge::Raw { percent, .. } => Battery {
                volts: None,
                low: percent < LOW_PERCENT,
            },
        })
    }

    /// Of an e-puck2, whose acceleration begins at 2048 here, and not over Wi-Fi (its main processor's firmware,
    /// `e_get_acc_filtered`). Firmware of the e-puck differs in that.
    fn lifted(&mut self) -> Result<bool> {
        const ZERO: f64 = 2048.0;
        if self.is_2() {
            let gravity = self.sense(&[Kind::Acceleration])?.values;
            return Ok(is_tilted(&gravity.iter().map(|part| part - ZERO).collect::<Vec<_>>()));
        }
        Err(self.description.lacks("sensors that show whether it is lifted", "none"))
    }

    fn odometry(&mut self) -> Result<Odometry> {
        let start = self.talk.now();
        let counts = match self.dialect {
            // An e-puck2 has more than 16 bits in text.
            Dialect::Text => self
                .numbers("Q\r", &[2])?
                .into_iter()
                .map(|count| count as i16)
                .collect(),
            Dialect::Binary => self.persistently(|robot| robot.chain("the step counters", &[negative(b'Q')], 2))?,
        };
        let at = self.talk.now();
        Ok(Odometry {
            at,
            age: at.saturating_sub(start),
            counts: self.steps.next([counts[0], counts[1]]),
        })
    }

    fn reconnect(&mut self) -> Result {
        let before = self.description.robot.clone();
        self.talk.link().reopen()?;
        self.begin()?;
        self.description.is_still(&before, self.talk.link().name())
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Charge {
    Flag(bool),
    Raw { raw: u16, percent: u8 },
}

/// The battery's charge in a line.
fn battery(line: &str) -> Result<Charge> {
    let bad = || garbage("b", line);
    let fields = talk::fields("b", line)?;
    let [field] = fields[..] else { return Err(bad()) };
    match field.split_once(' ') {
        None if field == "0" || field == "1" => Ok(Charge::Flag(field == "1")),
        None => Err(bad()),
        Some((raw, percent)) => {
            let percent = percent.strip_prefix('(').and_then(|percent| percent.strip_suffix("%)"));
            let percent = percent.and_then(|percent| percent.parse().ok());
            let (Ok(raw), Some(percent)) = (raw.parse(), percent) else {
                return Err(bad());
            };
            Ok(Charge::Raw { raw, percent })
        }
    }
}

/// The e-puck2's converter: 819.2 is 1 V, and below 2900 (3.54 V) the battery is low (its main processor's firmware).
pub(super) fn charge(raw: u16) -> Battery {
    Battery {
        volts: Some(f64::from(raw) / 819.2),
        low: raw < 2900,
    }
}

#[cfg(test)]
pub(super) mod tests;
