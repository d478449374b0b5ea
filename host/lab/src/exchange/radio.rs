//! The radio between robots and their operator: datagrams that only holders of the experiment's key can make, each of which counts
//! once. It has no sockets or clocks: the daemon carries sealed datagrams, and passes the time when it opens one.
//!
//! A datagram is refused if it has another format, version or experiment, was not made with the key, has come before, comes too often,
//! or has a value out of range: see [`Refusal`]. Nothing is encrypted.
//!
//! # What an attacker can do
//!
//! **Without the key**: read everything; jam the radio; delay datagrams, or hold some back. A flood of well-formed datagrams keeps
//! robots busy with at most [`rates::ALL`] authentications a second, but real datagrams are lost in it, so that the robots stand. No
//! value can be made or changed.
//!
//! **With a recorded datagram**, and without the key:
//!
//! - While the receiver runs: nothing, if the receiver has taken it, or has taken one of the same sender that is newer by 64
//!   or more. A datagram that was held back is taken once. A pair then counts only within [`limits::TOLERANCE`] seconds of
//!   its second. A beacon lets a robot move only until [`Beacons`](beacon::Beacons)' limit after it was sent, measured by the
//!   minimum delay of beacons so far: an attacker who has delayed all beacons from the first one on can keep robots going that
//!   much longer.
//! - After a restart of the receiver that has restored its [`Windows`]: datagrams that it took after they were saved are taken
//!   once more, until a datagram of the same sender has come that is newer by 64. Pairs are too old by then. Beacons let the
//!   robot move only while the operator's real ones are kept from it, and only for the time that the recorded ones cover.
//! - After a restart of the receiver without its windows: the same, for all datagrams recorded since the key was made. So a
//!   robot that has lost its directory needs an experiment with a new key.
//! - After a new start of the operator: nothing. The operator keeps its windows, and counts only datagrams with the number of
//!   its start. The number is drawn anew at each start; robots repeat it in each [`Status`] and [`Packet::Hello`]. A hello of
//!   another experiment under the same key, or a datagram of another version, can show a person what is wrong with a robot that
//!   sends nothing else.
//! - After a restart of the sender: no more than before. Its numbers begin with the count of its starts, so they are never used
//!   again, and all earlier ones are old once a new one has been taken. A sender that has lost its count is refused as replayed
//!   by every receiver that has taken its datagrams, until its count is as high as before.
//!
//! **With the key**: be any robot, or the operator. Pairs within the limits are then accepted, beacons let robots move, and a number
//! far ahead blocks the real sender. All robots have the same key, so one stolen robot is enough.

pub mod beacon;
mod format;
pub mod key;
pub(crate) mod limits;
mod rates;
mod replay;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::time::Duration;

use super::Message;
use format::{Datagram, HELLO, TAG};
use key::Key;
use limits::Limits;
use rates::Bucket;

pub use format::LONGEST;
pub use replay::Windows;

/// The operator's number; robots have 0 to robots - 1.
pub const OPERATOR: u16 = 0xffff;
/// Version of the datagrams. All robots and the operator must have the same.
pub const VERSION: u16 = 2;

/// The content of a datagram.
#[derive(Clone, Debug, PartialEq)]
pub enum Packet {
    /// A robot's simulator and fitness, in a second of the experiment.
    Pair {
        /// The second.
        second: u32,
        /// The pair; its sender is who sealed it.
        message: Message,
    },
    /// The operator is there.
    Beacon {
        /// The experiment's time, ms.
        milliseconds: i64,
        /// Whether robots may move; otherwise they stand.
        go: bool,
        /// The number of the operator's start.
        start: u64,
    },
    /// The operator has started, and asks who is there. It contains no time yet, and lets no robot move.
    Call {
        /// The number of the operator's start.
        start: u64,
    },
    /// A robot's state.
    Status(Status),
    /// The sender's program and experiment.
    Hello {
        /// Version of the program, up to 32 bytes.
        program: String,
        /// Hash of the experiment.
        experiment: [u8; 32],
        /// The number of the operator's start, as in [`Status::start`].
        start: u64,
    },
}

/// A robot's state, for the operator.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// The number of the operator's latest start that the robot has received; 0 if none. It is drawn anew at each start, so a status
    /// recorded before a start is not valid after it.
    pub start: u64,
    /// The experiment's time, ms.
    pub milliseconds: i64,
    /// The robot's activity, by the daemon's numbers.
    pub state: u8,
    /// The interval that it is in.
    pub interval: u32,
    /// The gene of its simulator.
    pub simulator: f32,
    /// Its fitness in the interval so far.
    pub real: f32,
    /// The fitness of its controller in the simulator; -1 if none was chosen there yet.
    pub simulated: f32,
    /// The controller that it acts by.
    pub controller: [f32; 2],
    /// Items that it has brought since the experiment began.
    pub brought: u32,
    /// Whether it carries one.
    pub carries: bool,
    /// x and y in mm, heading in turns.
    pub pose: [f32; 3],
    /// Voltage of its battery; -1 if that is unknown.
    pub volts: f32,
    /// Problems, a bit each, by the daemon's numbers.
    pub problems: u32,
    /// Datagrams and lines of the tracker that the robot has refused or ignored since its daemon began.
    pub ignored: u32,
}

/// A datagram that has been accepted.
#[derive(Clone, Debug, PartialEq)]
pub struct Received {
    /// Who sealed it.
    pub sender: u16,
    /// The datagram's number: the sender's starts in the high 32 bits, its datagrams since the start in the low ones.
    pub sequence: u64,
    /// Its content.
    pub packet: Packet,
}

/// Why a datagram is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// It has another format.
    #[error("is no datagram of Oneiro's")]
    NotOurs,
    /// It has another version. Nobody has authenticated it.
    #[error("has version {0} of datagrams; allowed: {VERSION}")]
    OtherVersion(u16),
    /// It is of another experiment.
    #[error("sender {sender} runs another experiment, {}", shown(*hash, program.as_deref()))]
    OtherExperiment {
        /// Who sealed it.
        sender: u16,
        /// The first bytes of that experiment's hash.
        hash: [u8; 8],
        /// The version of the sender's program, if the sender has the key and has said so. Otherwise nobody has authenticated it.
        program: Option<String>,
    },
    /// It was not sealed with the key, or was damaged.
    #[error("is forged or damaged")]
    Forged,
    /// It has come before, or is older than what has come before.
    #[error("has come before, or is too old")]
    Replayed,
    /// More have come than are allowed in this time.
    #[error("comes too often")]
    TooMany,
    /// This value is not one that the sender may send.
    #[error("{0} is out of range")]
    OutOfRange(&'static str),
    /// This radio has sent it.
    #[error("is from this robot itself")]
    Own,
}

fn shown(hash: [u8; 8], program: Option<&str>) -> String {
    let hash = format!("{:016x}", u64::from_be_bytes(hash));
    match program {
        Some(program) => format!("{hash}, with program {program}"),
        None => hash,
    }
}

impl Refusal {
    /// The reason in a word, for logs.
    pub fn reason(&self) -> &'static str {
        Refused::REASONS[self.index()]
    }

    fn index(&self) -> usize {
        match self {
            Self::NotOurs => 0,
            Self::OtherVersion(_) => 1,
            Self::OtherExperiment { .. } => 2,
            Self::Forged => 3,
            Self::Replayed => 4,
            Self::TooMany => 5,
            Self::OutOfRange(_) => 6,
            Self::Own => 7,
        }
    }
}

/// How many datagrams were refused for each reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Refused([u64; Self::REASONS.len()]);

impl Refused {
    const REASONS: [&str; 8] = [
        "not_ours",
        "other_version",
        "other_experiment",
        "forged",
        "replayed",
        "too_many",
        "out_of_range",
        "own",
    ];

    /// Each reason and its count.
    pub fn counts(&self) -> impl Iterator<Item = (&'static str, u64)> {
        Self::REASONS.into_iter().zip(self.0)
    }
}

/// Seals datagrams of one robot or of the operator, and opens those of the others.
pub struct Radio {
    own: u16,
    limits: Limits,
    /// The key of its tags.
    tags: [u8; blake3::KEY_LEN],
    experiment: [u8; 32],
    sequence: u64,
    windows: Windows,
    all: Bucket,
    each: BTreeMap<u16, Bucket>,
    refused: Refused,
}

impl Radio {
    /// The radio of a robot or of the operator at its start number `boots`, which must be greater than all before under this key, and on
    /// disk before the first datagram is sealed. `experiment` is the experiment's hash.
    pub fn new(own: u16, limits: Limits, key: &Key, experiment: [u8; 32], boots: u32) -> Self {
        Self {
            own,
            limits,
            tags: key.of_tags(),
            experiment,
            sequence: u64::from(boots) << 32,
            windows: Windows::default(),
            all: Bucket::default(),
            each: BTreeMap::new(),
            refused: Refused::default(),
        }
    }

    /// Makes a datagram.
    pub fn seal(&mut self, packet: &Packet) -> Vec<u8> {
        self.sequence = self.sequence.saturating_add(1);
        let mut bytes = format::sealed(packet, self.own, self.prefix(), self.sequence);
        let tag = self.tag(&bytes);
        bytes.extend_from_slice(&tag);
        bytes
    }

    /// The number of the datagram that was sealed last.
    pub fn sequence(&self) -> u64 {
        self.sequence
    }

    /// Opens a datagram that has come `now`, by any clock that never goes back, in this second of the experiment, if that is
    /// known.
    ///
    /// # Errors
    /// Why it is refused. Refusals are counted.
    pub fn open(&mut self, datagram: &[u8], now: Duration, second: Option<u32>) -> Result<Received, Refusal> {
        let opened = self.opened(datagram, now, second);
        if let Err(refusal) = &opened {
            self.refused.0[refusal.index()] += 1;
        }
        opened
    }

    /// Does the cheapest checks first. Datagrams from an attacker without the key change nothing except the budget of [`rates::ALL`].
    fn opened(&mut self, datagram: &[u8], now: Duration, second: Option<u32>) -> Result<Received, Refusal> {
        let datagram = Datagram::of(datagram)?;
        let Datagram { sender, sequence, .. } = datagram;
        let is_other = datagram.experiment != self.prefix();
        let other = |program| Refusal::OtherExperiment {
            sender,
            hash: datagram.experiment,
            program,
        };
        if is_other {
            // Only a hello contains the sender's program.
            if datagram.kind != HELLO {
                return Err(other(None));
            }
        } else if sender == self.own {
            return Err(Refusal::Own);
        } else if !self.limits.knows(sender) {
            return Err(Refusal::OutOfRange("sender"));
        } else if !self.windows.would_take(sender, sequence) {
            return Err(Refusal::Replayed);
        }
        if !self.all.take(&rates::ALL, now) {
            return Err(Refusal::TooMany);
        }
        if !is_same(self.tag(datagram.sealed), datagram.tag) {
            return Err(if is_other { other(None) } else { Refusal::Forged });
        }
        // Numbers of another experiment don't concern the robots of this one.
        if !is_other {
            self.windows.take(sender, sequence);
            if !self.each.entry(sender).or_default().take(rates::of(sender), now) {
                return Err(Refusal::TooMany);
            }
        }
        let packet = datagram.packet()?;
        match packet {
            Packet::Hello {
                program, experiment, ..
            } if is_other || experiment != self.experiment => Err(other(Some(program))),
            packet => {
                self.limits.check(&packet, sender, second)?;
                Ok(Received {
                    sender,
                    sequence,
                    packet,
                })
            }
        }
    }

    /// How many datagrams were refused.
    pub fn refused(&self) -> &Refused {
        &self.refused
    }

    /// The windows of accepted datagrams, to be saved.
    pub fn windows(&self) -> &Windows {
        &self.windows
    }

    /// Restores saved windows: no datagram accepted before they were saved is accepted again.
    pub fn restore(&mut self, windows: Windows) {
        self.windows = windows;
    }

    /// The first bytes of the experiment's hash, as in a header.
    fn prefix(&self) -> [u8; 8] {
        format::prefix(&self.experiment)
    }

    fn tag(&self, bytes: &[u8]) -> [u8; TAG] {
        let mut tag = [0; TAG];
        tag.copy_from_slice(&blake3::keyed_hash(&self.tags, bytes).as_bytes()[..TAG]);
        tag
    }
}

/// Compares tags like hashes, in a time that does not depend on where they differ.
fn is_same(a: [u8; TAG], b: [u8; TAG]) -> bool {
    let hash = |tag: [u8; TAG]| {
        let mut all = [0; blake3::OUT_LEN];
        all[..TAG].copy_from_slice(&tag);
        blake3::Hash::from_bytes(all)
    };
    hash(a) == hash(b)
}
