//! Messages between the conductor and the participants that it gives time: daemons and guards. One side at a time
//! works: a participant works and then waits, and the conductor lets time pass until there is something for the
//! participant.
//!
//! To a daemon's process a message is its length, 4 bytes, little endian, and then the message as postcard.

use std::io::{self, BufReader, Read, Write};
use std::os::unix::net::UnixStream;
#[cfg(feature = "twin")]
use std::time::Duration;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Version of the messages. A participant sends its version first.
pub(super) const VERSION: u32 = 1;
/// The longest message, bytes.
const LONGEST: usize = 1 << 20;

/// A participant's message. Only [`Up::Wait`] is answered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Up {
    /// The first message.
    Hello {
        /// The participant's [`VERSION`].
        version: u32,
        /// The robot's number.
        robot: u32,
    },
    /// Bytes for the robot, on its serial line.
    Line(Vec<u8>),
    /// The serial line is opened again: bytes under way are lost.
    Reopen,
    /// A line between a daemon and its guard.
    Tell(String),
    /// A datagram to all other robots and to the operator.
    Send(Vec<u8>),
    /// There is nothing to do until something comes, or until a moment of the participant's clock, in ns.
    Wait {
        /// The moment.
        until: u64,
        /// Whether bytes of the serial line end the waiting.
        line: bool,
        /// Whether lines of the daemon or the guard end it.
        told: bool,
    },
}

/// The conductor's message: the time, and what has arrived.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Time {
    /// The time on the participant's clock, ns.
    pub(super) now: u64,
    /// Whether the experiment is over.
    pub(super) ended: bool,
    /// Whether the daemon of this guard, or the guard of this daemon, is gone.
    pub(super) closed: bool,
    /// Bytes from the robot.
    pub(super) line: Vec<u8>,
    /// Lines from the daemon or the guard.
    pub(super) told: Vec<String>,
    /// Datagrams, each with whether it is of the tracker.
    pub(super) datagrams: Vec<(bool, Vec<u8>)>,
}

/// One end of a connection.
pub(super) struct Port(BufReader<UnixStream>);

impl Port {
    pub(super) fn new(stream: UnixStream) -> Self {
        Self(BufReader::new(stream))
    }

    #[cfg(feature = "twin")]
    /// Limits how long a message may take to come; for ever without a limit.
    pub(super) fn limit(&self, limit: Option<Duration>) -> io::Result<()> {
        self.0.get_ref().set_read_timeout(limit)
    }

    #[cfg(feature = "twin")]
    /// Ends the connection, also for the other end.
    pub(super) fn close(&self) {
        // It may be closed already.
        let _ = self.0.get_ref().shutdown(std::net::Shutdown::Both);
    }

    /// Sends messages.
    ///
    /// # Errors
    /// The other end is gone.
    pub(super) fn send(&mut self, messages: &[impl Serialize]) -> io::Result<()> {
        let mut all = Vec::new();
        for message in messages {
            let bytes = postcard::to_allocvec(message).unwrap_or_default();
            all.extend((bytes.len() as u32).to_le_bytes());
            all.extend(bytes);
        }
        self.0.get_mut().write_all(&all)
    }

    /// The next message.
    ///
    /// # Errors
    /// The other end is gone, or has sent what is no message.
    pub(super) fn receive<T: DeserializeOwned>(&mut self) -> io::Result<T> {
        let mut length = [0; 4];
        self.0.read_exact(&mut length)?;
        let length = u32::from_le_bytes(length) as usize;
        if length > LONGEST {
            return Err(invalid(format!(
                "a message of {length} bytes; allowed: up to {LONGEST}"
            )));
        }
        let mut bytes = vec![0; length];
        self.0.read_exact(&mut bytes)?;
        postcard::from_bytes(&bytes).map_err(|error| invalid(error.to_string()))
    }
}

fn invalid(problem: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, problem)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_arrive_in_order_and_nonsense_does_not() {
        let (one, other) = UnixStream::pair().unwrap();
        let (mut one, mut other) = (Port::new(one), Port::new(other));
        let wait = Up::Wait {
            until: u64::MAX,
            line: true,
            told: false,
        };
        one.send(&[Up::Line(vec![0, 255]), wait.clone()]).unwrap();
        assert_eq!(other.receive::<Up>().unwrap(), Up::Line(vec![0, 255]));
        assert_eq!(other.receive::<Up>().unwrap(), wait);
        let time = Time {
            told: vec!["{}".into()],
            datagrams: vec![(true, vec![1])],
            ..Time::default()
        };
        other.send(std::slice::from_ref(&time)).unwrap();
        assert_eq!(one.receive::<Time>().unwrap(), time);
        for bytes in [&[255, 255, 255, 255][..], &[1, 0, 0, 0, 77]] {
            other.0.get_mut().write_all(bytes).unwrap();
            assert_eq!(one.receive::<Up>().unwrap_err().kind(), io::ErrorKind::InvalidData);
        }
        drop(other);
        assert!(one.receive::<Time>().is_err());
    }
}
