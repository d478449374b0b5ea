//! e-puck2 over Wi-Fi: TCP port 1000 of its radio (GCtronic, e-puck2 radio firmware, socket_e-puck2.c).
//!
//! A command has 21 bytes and sets everything: speeds, lights, sound, and what is wanted back. From the first one on, the
//! radio passes the last command to the main processor and sends an answer, again and again, up to 50 times a second. When
//! it can't get rid of its answers it takes no commands, and the wheels turn on: so all received bytes are read before each
//! command. What a computer's TCP holds back is enough for half a minute; whoever drives calls more often.
//!
//! An answer has the readings from before the command was passed on. After an error between its two processors the radio
//! pauses for 1 s. It serves one client, and when that is gone the robot keeps its last speed.

use std::time::Duration;

use super::epuck::{self, ACCELERATION, DISTANCE, GROUND, LIGHT, LIGHTS, PROXIMITY, ROTATION, WHEELS};
use super::error::{Error, Result};
use super::link::{self, Link};
use super::talk::garbage;
use super::{Battery, Description, Group, Kind, Odometry, Reading, Robot, Unwrapped, is_tilted};

/// The radio pauses for 1 s after an error.
const PATIENCE: Duration = Duration::from_millis(1500);
const SEND: Duration = Duration::from_millis(200);
/// Less than the radio pauses when the main processor restarts, and more than a network usually holds answers back.
const SILENCE: Duration = Duration::from_millis(500);
/// The longest cycle of the radio that is usual.
const CYCLE: Duration = Duration::from_millis(50);
/// The counters must stand for as long before the wheels are said to: they show 2 steps/s, which is 0.26 mm/s.
const STANDSTILL: Duration = Duration::from_millis(500);
/// Number of consecutive answers that must show it. The radio sends one in 20 ms at most: however late they come and however close
/// together, they span 0.2 s, and show 5 steps/s.
const EQUAL: usize = 10;
/// The same where a stop can't take that long to confirm: it shows 10 steps/s.
const BRIEF_STANDSTILL: Duration = Duration::from_millis(100);
const BRIEF_EQUAL: usize = 4;

const SOUND: Group = Group {
    kind: Kind::Sound,
    names: &["sound_right", "sound_left", "sound_back", "sound_front"],
    ..epuck::SOUND
};
const MAGNETISM: Group = Group {
    kind: Kind::Magnetism,
    names: &["magnetism_x", "magnetism_y", "magnetism_z"],
    unit: "uT",
    range: (-1e6, 1e6),
};
const TEMPERATURE: Group = Group {
    kind: Kind::Temperature,
    names: &["temperature"],
    unit: "degrees C",
    range: (-128.0, 127.0),
};
const BUTTON: Group = Group {
    kind: Kind::Button,
    names: &["button"],
    unit: "",
    range: (0.0, 1.0),
};

/// How a number is stored, lowest byte first.
#[derive(Clone, Copy, Debug)]
enum Format {
    U8,
    I8,
    U16,
    I16,
    F32,
}

/// Where a block has the sensors (e-puck2 main processor, Asercom2.c; the last two bytes by the radio).
const LAYOUT: [(Group, usize, Format); 10] = [
    (ACCELERATION, 0, Format::I16),
    (ROTATION, 18, Format::I16),
    (MAGNETISM, 24, Format::F32),
    (TEMPERATURE, 36, Format::I8),
    (PROXIMITY, 37, Format::U16),
    (LIGHT, 53, Format::U16),
    (DISTANCE, 69, Format::U16),
    (SOUND, 71, Format::U16),
    (GROUND, 90, Format::U16),
    (BUTTON, 102, Format::U8),
];

/// All sensors, as they come.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Block([u8; Block::LENGTH]);

impl Block {
    const LENGTH: usize = 104;

    /// Readings of a group that starts at a byte.
    fn group(&self, group: Group, start: usize, format: Format) -> Vec<f64> {
        let byte = |at: usize| self.0[start + at];
        let word = |at: usize| [byte(2 * at), byte(2 * at + 1)];
        (0..group.names.len())
            .map(|at| match format {
                Format::U8 => f64::from(byte(at)),
                Format::I8 => f64::from(byte(at) as i8),
                Format::U16 => f64::from(u16::from_le_bytes(word(at))),
                Format::I16 => f64::from(i16::from_le_bytes(word(at))),
                Format::F32 => {
                    let [[a, b], [c, d]] = [word(2 * at), word(2 * at + 1)];
                    f64::from(f32::from_le_bytes([a, b, c, d]))
                }
            })
            .collect()
    }

    /// Whether all readings are within their ranges.
    fn is_sane(&self) -> bool {
        LAYOUT
            .iter()
            .all(|&(group, start, format)| group.accepts(&self.group(group, start, format)))
    }

    fn word(&self, at: usize) -> u16 {
        u16::from_le_bytes([self.0[at], self.0[at + 1]])
    }

    fn steps(&self) -> [i16; 2] {
        [self.word(79) as i16, self.word(81) as i16]
    }

    fn battery(&self) -> u16 {
        self.word(83)
    }
}

/// Splits the radio's stream into answers. Holds less than one answer between calls.
#[derive(Debug, Default)]
struct Answers {
    bytes: Vec<u8>,
    /// Bytes of an image that are still to come.
    image: usize,
    /// A byte that began no answer: where the next one begins is unknown since then.
    lost: Option<u8>,
}

impl Answers {
    /// 160 x 120 pixels of 16 bits.
    const IMAGE: usize = 38_400;

    /// Adds bytes, and returns the blocks of sensors that they complete.
    ///
    /// # Errors
    /// A byte that began no answer, now or before.
    fn push(&mut self, bytes: &[u8]) -> std::result::Result<Vec<Block>, u8> {
        if let Some(byte) = self.lost {
            return Err(byte);
        }
        self.bytes.extend_from_slice(bytes);
        let (mut rest, mut blocks) = (&self.bytes[..], Vec::new());
        loop {
            let skipped = self.image.min(rest.len());
            self.image -= skipped;
            rest = &rest[skipped..];
            match rest {
                [1, ..] => {
                    self.image = Self::IMAGE;
                    rest = &rest[1..];
                }
                [2, after @ ..] => match after.split_first_chunk() {
                    Some((block, next)) => {
                        blocks.push(Block(*block));
                        rest = next;
                    }
                    None => break,
                },
                [3, after @ ..] => rest = after,
                [other, ..] => {
                    self.lost = Some(*other);
                    return Err(*other);
                }
                [] => break,
            }
        }
        let left = rest.len();
        self.bytes.drain(..self.bytes.len() - left);
        Ok(blocks)
    }
}

/// A block and when it was taken.
#[derive(Clone, Debug)]
struct Arrival {
    block: Block,
    at: Duration,
    /// The earliest time at which it can have come: that of the last look, unless it was waited for.
    earliest: Duration,
    /// Maximum age of its readings, without the time that the network takes.
    age: Duration,
}

/// An e-puck2 on Wi-Fi.
pub(crate) struct EPuck2 {
    link: Box<dyn Link>,
    description: Description,
    answers: Answers,
    /// The last command.
    command: [u8; 21],
    newest: Option<Arrival>,
    /// Number of blocks so far.
    blocks: u64,
    /// Whether any block has come, possible or not.
    has_answered: bool,
    /// When all that had come was taken.
    looked: Duration,
    steps: Unwrapped<16>,
}

impl EPuck2 {
    /// Sends the first command, a stop, and waits until the robot has obeyed. None if no e-puck2 answers.
    ///
    /// # Errors
    /// An e-puck2 answers and does not stop, or the link fails.
    pub(crate) fn connect(link: Box<dyn Link>) -> Result<Option<Self>> {
        let mut robot = Self {
            looked: link.now(),
            link,
            description: Description {
                robot: "e-puck2".into(),
                firmware: "Wi-Fi; version not reported".into(),
                sensors: LAYOUT.iter().map(|(group, ..)| *group).collect(),
                wheels: WHEELS,
                lights: LIGHTS,
            },
            answers: Answers::default(),
            command: [0; 21],
            newest: None,
            blocks: 0,
            has_answered: false,
            steps: Unwrapped::default(),
        };
        match robot.begin() {
            Ok(()) => Ok(Some(robot)),
            Err(error) if error.may_pass() && !robot.has_answered => Ok(None),
            Err(error) => Err(error),
        }
    }

    fn begin(&mut self) -> Result {
        // 0x80 begins a command; 2 asks for the sensors; no other bit is ever set, since the radio would repeat it.
        self.command[0] = 0x80;
        self.command[1] = 2;
        self.stop()
    }

    /// Takes what has come, at `earliest` or later. Blocks that can't be are left out: the line between the processors has
    /// no checksum. The readings of a block are from after the one before was sent; of blocks that come together, from after
    /// those that came before them. After a restart of the main processor the radio passes on its last command again, so
    /// it gets another one.
    fn take(&mut self, bytes: &[u8], earliest: Duration) -> Result {
        let blocks = self.answers.push(bytes);
        let blocks = blocks.map_err(|byte| garbage("a command", &format!("the unknown header {byte:#04x}")))?;
        self.has_answered |= !blocks.is_empty();
        let at = self.link.now();
        let newest = self.newest.as_ref();
        let since = newest.map_or(CYCLE, |newest| at.saturating_sub(newest.earliest));
        for block in blocks.into_iter().filter(Block::is_sane) {
            if self.has_restarted(block.steps(), since) {
                self.steps = Unwrapped::default();
                self.newest = None;
                self.set_speeds([0; 2]);
                self.transmit()?;
                return Err(Error::Restarted);
            }
            self.steps.next(block.steps());
            self.blocks += 1;
            self.newest = Some(Arrival {
                block,
                at,
                earliest,
                age: since.max(CYCLE),
            });
        }
        Ok(())
    }

    /// Whether the counters have restarted: after a silence both are 0 and were not, or they have changed by more than the
    /// wheels can turn, the radio's pause included. The first answer after a restart has them from before the radio has passed
    /// on its command.
    fn has_restarted(&self, steps: [i16; 2], since: Duration) -> bool {
        let Some(change) = self.steps.change(steps) else {
            return false;
        };
        let most = 1100.0 * (since + PATIENCE).as_secs_f64();
        let is_anew = since >= SILENCE && steps == [0; 2] && change != [0; 2];
        is_anew || change.iter().any(|counts| counts.abs() as f64 > most)
    }

    /// Reads all that waits.
    fn drain(&mut self) -> Result {
        let mut buffer = [0; 4096];
        // As much as an operating system keeps for a connection, and no more: this must end.
        for _ in 0..2048 {
            match self.link.waiting(&mut buffer)? {
                0 => {
                    self.looked = self.link.now();
                    break;
                }
                count => self.take(&buffer[..count], self.looked)?,
            }
        }
        Ok(())
    }

    /// Waits for the next block; none once the time has passed.
    fn arrival(&mut self, until: Duration) -> Result<Option<Arrival>> {
        let before = self.blocks;
        let mut buffer = [0; 4096];
        loop {
            match &self.newest {
                Some(newest) if self.blocks > before => return Ok(Some(newest.clone())),
                _ => {}
            }
            let count = self.link.read(&mut buffer, until)?;
            if count < buffer.len() {
                self.looked = self.link.now();
            }
            match count {
                0 => return Ok(None),
                _ => self.take(&buffer[..count], self.looked)?,
            }
        }
    }

    /// The next block.
    fn next(&mut self) -> Result<Arrival> {
        let until = self.link.now() + PATIENCE;
        self.arrival(until)?.ok_or_else(|| silent(PATIENCE))
    }

    /// The newest block, if it came within a cycle; else the next one.
    fn current(&mut self) -> Result<Arrival> {
        self.drain()?;
        let oldest = self.link.now().saturating_sub(CYCLE);
        match &self.newest {
            Some(newest) if newest.earliest >= oldest => Ok(newest.clone()),
            _ => self.next(),
        }
    }

    fn set_speeds(&mut self, speeds: [i16; 2]) {
        self.command = with_speeds(self.command, speeds);
    }

    /// Sends the command. It is sent even if what has come makes no sense, since it may be a stop; after a restart a stop
    /// was sent instead.
    fn send(&mut self) -> Result {
        match self.drain() {
            Err(Error::Restarted) => Err(Error::Restarted),
            drained => self.transmit().and(drained),
        }
    }

    /// Sends the command in one piece: of a part the radio would wait for the rest.
    fn transmit(&mut self) -> Result {
        link::send_whole(&mut *self.link, &self.command, SEND)
    }

    /// Stops the wheels, and waits until `answers` consecutive answers, received over at least `standstill`, show the same
    /// step counters.
    fn stand(&mut self, standstill: Duration, answers: usize) -> Result {
        self.drive(0, 0)?;
        let limit = PATIENCE + standstill;
        let until = self.link.now() + limit;
        let (mut first, mut equal): (Option<Arrival>, usize) = (None, 0);
        while let Some(arrival) = self.arrival(until)? {
            match &first {
                Some(first) if first.block.steps() == arrival.block.steps() => {
                    equal += 1;
                    if equal >= answers && arrival.at >= first.at + standstill {
                        return Ok(());
                    }
                }
                _ => (first, equal) = (Some(arrival), 1),
            }
        }
        Err(first.map_or(silent(limit), |last| Error::StillTurning {
            seen: format!(
                "its step counters have not stood still for {} ms; they were at {:?} last",
                standstill.as_millis(),
                last.block.steps()
            ),
        }))
    }
}

/// A command with these speeds.
fn with_speeds(mut command: [u8; 21], speeds: [i16; 2]) -> [u8; 21] {
    for (wheel, speed) in speeds.into_iter().enumerate() {
        command[3 + 2 * wheel..][..2].copy_from_slice(&speed.to_le_bytes());
    }
    command
}

fn silent(limit: Duration) -> Error {
    Error::TimedOut {
        command: "a command over Wi-Fi".into(),
        limit,
    }
}

impl Robot for EPuck2 {
    fn description(&self) -> &Description {
        &self.description
    }

    fn halt(&self) -> Vec<u8> {
        with_speeds(self.command, [0; 2]).into()
    }

    fn sense(&mut self, kinds: &[Kind]) -> Result<Reading> {
        let groups = self.description.groups(kinds)?;
        let Arrival { block, at, age, .. } = self.current()?;
        let layout = groups
            .iter()
            .filter_map(|group| LAYOUT.iter().find(|(known, ..)| known == group));
        let values = layout.flat_map(|&(group, start, format)| block.group(group, start, format));
        Ok(Reading {
            at,
            age,
            values: values.collect(),
        })
    }

    fn drive(&mut self, left: i32, right: i32) -> Result {
        self.set_speeds([left, right].map(|speed| speed.clamp(-WHEELS.greatest, WHEELS.greatest) as i16));
        self.send()
    }

    /// A command has no separate answer, so the step counters must stand still.
    fn stop(&mut self) -> Result {
        self.stand(STANDSTILL, EQUAL)
    }

    fn stop_briefly(&mut self) -> Result {
        self.stand(BRIEF_STANDSTILL, BRIEF_EQUAL)
    }

    fn light(&mut self, light: usize, on: bool) -> Result {
        self.description.light(light)?;
        // LEDs 1, 3, 5 and 7, the body's and the front's are bits; 2, 4, 6 and 8 have a red, green and blue of 0 to 100.
        let bit = match light {
            0 | 2 | 4 | 6 => 1 << (light / 2),
            8 => 0x10,
            9 => 0x20,
            _ => {
                self.command[8 + 3 * (light / 2)..][..3].fill(if on { 100 } else { 0 });
                return self.send();
            }
        };
        if on {
            self.command[7] |= bit;
        } else {
            self.command[7] &= !bit;
        }
        self.send()
    }

    fn battery(&mut self) -> Result<Battery> {
        Ok(epuck::charge(self.current()?.block.battery()))
    }

    /// An e-puck2 that stands upright measures about 768 along the third axis (its main processor's firmware, `e_get_acc`).
    fn lifted(&mut self) -> Result<bool> {
        Ok(is_tilted(&self.sense(&[Kind::Acceleration])?.values))
    }

    fn odometry(&mut self) -> Result<Odometry> {
        let Arrival { at, age, .. } = self.current()?;
        Ok(Odometry {
            at,
            age,
            counts: self.steps.total,
        })
    }

    /// The radio may refuse after some eight connections, since it never closes a lost one: then reset it.
    fn reconnect(&mut self) -> Result {
        self.link.reopen()?;
        self.answers = Answers::default();
        self.newest = None;
        self.looked = self.link.now();
        self.steps = Unwrapped::default();
        self.begin()
    }
}

#[cfg(test)]
pub(super) mod tests;
