//! Recordings, played back. For tests.

use std::collections::VecDeque;
use std::time::Duration;

use super::super::error::{Error, Result};
use super::super::link::{Clock, Link};
use super::TITLE;

/// A recorded link, played back. Each call returns what it returned then; the clock shows the time of then.
#[derive(Debug)]
pub struct Replay {
    name: String,
    events: VecDeque<(Duration, Event)>,
    now: Duration,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Event {
    Sent(Vec<u8>),
    Received(Vec<u8>),
    Opened,
    Failed(Error),
}

impl Replay {
    /// Reads a recording: its links in the order of their opening.
    ///
    /// # Errors
    /// The line that is not of a recording.
    pub fn parse(text: &str) -> std::result::Result<Vec<Self>, String> {
        let mut lines = text.lines().zip(1..);
        if lines.next().is_none_or(|(title, _)| title != TITLE) {
            return Err(format!("line 1: is no recording; allowed: \"{TITLE}\""));
        }
        let mut links: Vec<Self> = Vec::new();
        for (line, number) in lines {
            let bad = || format!("line {number}: \"{line}\" is no event of a link");
            let (now, what, rest) = fields(line).ok_or_else(bad)?;
            if what == "=" {
                links.push(Self {
                    name: rest.into(),
                    events: VecDeque::new(),
                    now,
                });
            } else if what == "+" {
                // No driver has sent it.
                bytes(rest).ok_or_else(bad)?;
            } else {
                let link = links.last_mut().ok_or_else(bad)?;
                link.events.push_back((now, event(what, rest).ok_or_else(bad)?));
            }
        }
        Ok(links)
    }

    /// Whether all of it has been played.
    pub fn is_over(&self) -> bool {
        self.events.is_empty()
    }

    /// The next event, which must be what the recording has.
    pub(super) fn next(&mut self, asked: &str) -> Result<Event> {
        let next = self.events.pop_front();
        let (at, event) = next.ok_or_else(|| self.departed(format!("the recording ends here, before {asked}")))?;
        self.now = at;
        match event {
            Event::Failed(error) => Err(error),
            event => Ok(event),
        }
    }

    fn departed(&self, cause: String) -> Error {
        Error::Disconnected {
            link: self.name.clone(),
            cause,
        }
    }

    fn other(&self, event: &Event, asked: &str) -> Error {
        self.departed(format!("at {:?} the recording has {event:?} and not {asked}", self.now))
    }
}

/// Time, what happened, and the rest of a line.
fn fields(line: &str) -> Option<(Duration, &str, &str)> {
    let (seconds, rest) = line.split_once(' ')?;
    let at = Duration::try_from_secs_f64(seconds.parse().ok()?).ok()?;
    let (what, rest) = rest.split_once(' ')?;
    Some((at, what, rest))
}

fn event(what: &str, rest: &str) -> Option<Event> {
    match what {
        ">" => bytes(rest).map(Event::Sent),
        "<" => bytes(rest).map(Event::Received),
        "o" => Some(Event::Opened),
        "x" => serde_json::from_str(rest).ok().map(Event::Failed),
        _ => None,
    }
}

fn bytes(hex: &str) -> Option<Vec<u8>> {
    let digit = |byte: u8| char::from(byte).to_digit(16);
    let (pairs, rest) = hex.as_bytes().as_chunks::<2>();
    let bytes = pairs
        .iter()
        .map(|[high, low]| Some((digit(*high)? << 4 | digit(*low)?) as u8));
    if rest.is_empty() { bytes.collect() } else { None }
}

impl Clock for Replay {
    fn now(&self) -> Duration {
        self.now
    }
}

impl Link for Replay {
    fn name(&self) -> &str {
        &self.name
    }

    fn read(&mut self, buffer: &mut [u8], _: Duration) -> Result<usize> {
        self.waiting(buffer)
    }

    fn waiting(&mut self, buffer: &mut [u8]) -> Result<usize> {
        match self.next("a read")? {
            Event::Received(bytes) if bytes.len() <= buffer.len() => {
                buffer[..bytes.len()].copy_from_slice(&bytes);
                Ok(bytes.len())
            }
            event => Err(self.other(&event, "a read")),
        }
    }

    fn write(&mut self, bytes: &[u8], _: Duration) -> Result {
        match self.next("a write")? {
            Event::Sent(sent) if sent == bytes => Ok(()),
            event => Err(self.other(&event, &format!("{:?}", Event::Sent(bytes.into())))),
        }
    }

    fn reopen(&mut self) -> Result {
        match self.next("opening")? {
            Event::Opened => Ok(()),
            event => Err(self.other(&event, "opening")),
        }
    }
}
