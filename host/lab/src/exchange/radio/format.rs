//! Datagrams as bytes, little endian: magic, version, kind, sender, the first bytes of the experiment's hash, sequence, body, tag.

use super::{Packet, Refusal, Status, VERSION};
use crate::exchange::Message;

const MAGIC: [u8; 4] = *b"1ONE";
const HEADER: usize = 25;
/// Bytes of the number of the operator's start.
const START: usize = 8;
/// Bytes of a tag.
pub(super) const TAG: usize = 16;
/// The longest name of a program, in bytes.
const PROGRAM: usize = 32;
/// The longest datagram, in bytes: a hello.
pub const LONGEST: usize = HEADER + START + 1 + PROGRAM + blake3::OUT_LEN + TAG;

const PAIR: u8 = 1;
const BEACON: u8 = 2;
const STATUS: u8 = 3;
pub(super) const HELLO: u8 = 4;
const CALL: u8 = 5;

/// The part of an experiment's hash that a header has.
pub(super) fn prefix(experiment: &[u8; 32]) -> [u8; 8] {
    let mut prefix = [0; 8];
    prefix.copy_from_slice(&experiment[..8]);
    prefix
}

/// All of a datagram except its tag.
pub(super) fn sealed(packet: &Packet, sender: u16, experiment: [u8; 8], sequence: u64) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(LONGEST);
    let mut put = |field: &[u8]| bytes.extend_from_slice(field);
    put(&MAGIC);
    put(&VERSION.to_le_bytes());
    put(&[kind(packet)]);
    put(&sender.to_le_bytes());
    put(&experiment);
    put(&sequence.to_le_bytes());
    let numbers = |numbers: &[f32]| {
        numbers
            .iter()
            .flat_map(|number| number.to_le_bytes())
            .collect::<Vec<u8>>()
    };
    match packet {
        Packet::Pair { second, message } => {
            put(&second.to_le_bytes());
            put(&message.interval.to_le_bytes());
            put(&numbers(&[message.simulator, message.fitness]));
            put(&numbers(&message.controller));
        }
        Packet::Beacon {
            milliseconds,
            go,
            start,
        } => {
            put(&milliseconds.to_le_bytes());
            put(&[(*go).into()]);
            put(&start.to_le_bytes());
        }
        Packet::Call { start } => put(&start.to_le_bytes()),
        Packet::Status(status) => {
            put(&status.start.to_le_bytes());
            put(&status.milliseconds.to_le_bytes());
            put(&[status.state]);
            put(&status.interval.to_le_bytes());
            put(&numbers(&[status.simulator, status.real, status.simulated]));
            put(&numbers(&status.controller));
            put(&status.brought.to_le_bytes());
            put(&[status.carries.into()]);
            put(&numbers(&status.pose));
            put(&numbers(&[status.volts]));
            put(&status.problems.to_le_bytes());
            put(&status.ignored.to_le_bytes());
        }
        Packet::Hello {
            program,
            experiment,
            start,
        } => {
            put(&start.to_le_bytes());
            let program = &program[..program.floor_char_boundary(PROGRAM)];
            put(&[program.len() as u8]);
            put(program.as_bytes());
            put(experiment);
        }
    }
    bytes
}

fn kind(packet: &Packet) -> u8 {
    match packet {
        Packet::Pair { .. } => PAIR,
        Packet::Beacon { .. } => BEACON,
        Packet::Status(_) => STATUS,
        Packet::Hello { .. } => HELLO,
        Packet::Call { .. } => CALL,
    }
}

/// The parts of a datagram that is not authenticated yet.
#[derive(Clone, Copy)]
pub(super) struct Datagram<'a> {
    pub(super) kind: u8,
    pub(super) sender: u16,
    pub(super) experiment: [u8; 8],
    pub(super) sequence: u64,
    body: &'a [u8],
    /// All bytes that the tag covers.
    pub(super) sealed: &'a [u8],
    pub(super) tag: [u8; TAG],
}

impl<'a> Datagram<'a> {
    /// Takes a datagram apart.
    ///
    /// # Errors
    /// It is not ours, or of another version.
    pub(super) fn of(datagram: &'a [u8]) -> Result<Self, Refusal> {
        // The fields that all versions have come first.
        let rest = datagram.strip_prefix(&MAGIC).ok_or(Refusal::NotOurs)?;
        let (version, _) = rest.split_first_chunk().ok_or(Refusal::NotOurs)?;
        match u16::from_le_bytes(*version) {
            VERSION => {}
            other => return Err(Refusal::OtherVersion(other)),
        }
        if datagram.len() > LONGEST {
            return Err(Refusal::NotOurs);
        }
        let (sealed, tag) = datagram.split_last_chunk().ok_or(Refusal::NotOurs)?;
        let header = || {
            let mut fields = Fields(sealed.get(MAGIC.len() + size_of_val(&VERSION)..).unwrap_or_default());
            Ok(Self {
                kind: fields.byte()?,
                sender: u16::from_le_bytes(fields.array()?),
                experiment: fields.array()?,
                sequence: u64::from_le_bytes(fields.array()?),
                body: fields.0,
                sealed,
                tag: *tag,
            })
        };
        header().map_err(|_: Refusal| Refusal::NotOurs)
    }

    /// The content, whatever its values are.
    ///
    /// # Errors
    /// The part that can't be read.
    pub(super) fn packet(&self) -> Result<Packet, Refusal> {
        let mut body = Fields(self.body);
        let packet = match self.kind {
            PAIR => Packet::Pair {
                second: body.word()?,
                message: Message {
                    sender: self.sender.into(),
                    interval: body.word()?,
                    simulator: body.number()?,
                    fitness: body.number()?,
                    controller: body.numbers()?,
                },
            },
            BEACON => Packet::Beacon {
                milliseconds: body.time()?,
                go: body.flag("go")?,
                start: body.long()?,
            },
            CALL => Packet::Call { start: body.long()? },
            STATUS => Packet::Status(Status {
                start: body.long()?,
                milliseconds: body.time()?,
                state: body.byte()?,
                interval: body.word()?,
                simulator: body.number()?,
                real: body.number()?,
                simulated: body.number()?,
                controller: body.numbers()?,
                brought: body.word()?,
                carries: body.flag("carries")?,
                pose: body.numbers()?,
                volts: body.number()?,
                problems: body.word()?,
                ignored: body.word()?,
            }),
            HELLO => Packet::Hello {
                start: body.long()?,
                program: body.program()?,
                experiment: body.array()?,
            },
            _ => return Err(Refusal::OutOfRange("kind")),
        };
        if body.0.is_empty() { Ok(packet) } else { Err(SHORT) }
    }
}

const SHORT: Refusal = Refusal::OutOfRange("length");

/// The fields of a body that are still to be read.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn array<const N: usize>(&mut self) -> Result<[u8; N], Refusal> {
        let (first, rest) = self.0.split_first_chunk().ok_or(SHORT)?;
        self.0 = rest;
        Ok(*first)
    }

    fn byte(&mut self) -> Result<u8, Refusal> {
        let [byte] = self.array()?;
        Ok(byte)
    }

    fn flag(&mut self, name: &'static str) -> Result<bool, Refusal> {
        match self.byte()? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(Refusal::OutOfRange(name)),
        }
    }

    fn word(&mut self) -> Result<u32, Refusal> {
        self.array().map(u32::from_le_bytes)
    }

    fn long(&mut self) -> Result<u64, Refusal> {
        self.array().map(u64::from_le_bytes)
    }

    fn time(&mut self) -> Result<i64, Refusal> {
        self.array().map(i64::from_le_bytes)
    }

    fn number(&mut self) -> Result<f32, Refusal> {
        self.array().map(f32::from_le_bytes)
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f32; N], Refusal> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number()?;
        }
        Ok(numbers)
    }

    fn program(&mut self) -> Result<String, Refusal> {
        let count = self.byte()?.into();
        let refused = || Refusal::OutOfRange("program");
        if count > PROGRAM {
            return Err(refused());
        }
        let (program, rest) = self.0.split_at_checked(count).ok_or(SHORT)?;
        self.0 = rest;
        let program = str::from_utf8(program).map_err(|_| refused())?;
        // It is shown on terminals.
        if program.chars().any(char::is_control) {
            return Err(refused());
        }
        Ok(program.to_owned())
    }
}
