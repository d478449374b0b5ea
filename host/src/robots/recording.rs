//! Recordings of links: all bytes with their time and direction, as text. A bug report carries one, and a test replays
//! it: a driver decides by nothing but what its link returns, so it does the same again.
//!
//! One line for each call to the link: seconds, what happened, and the bytes in hexadecimal. `>` bytes sent, `<` bytes
//! received (none: waited in vain), `o` opened again, `x` failed, with the message.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::mpsc::{self, SyncSender, TrySendError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use super::error::{Error, Result};
use super::link::{Clock, Link};

const TITLE: &str = "oneiro link recording 1";

/// A file that links are recorded to. It is written by a thread of its own: a slow or full disk must not hold a robot.
#[derive(Debug)]
pub(crate) struct Recording {
    lines: Option<SyncSender<String>>,
    writer: Option<JoinHandle<()>>,
    problem: Arc<Mutex<Option<String>>>,
}

impl Recording {
    /// Lines that wait for the disk; more are lost.
    const MOST: usize = 10_000;

    /// Starts a recording in a new file.
    ///
    /// # Errors
    /// The file exists, or can't be written.
    pub(crate) fn create(path: &Path) -> std::io::Result<Self> {
        let mut file = File::create_new(path)?;
        writeln!(file, "{TITLE}")?;
        Ok(Self::to(file, path))
    }

    /// Starts a recording in a file that has its title.
    fn to(mut file: File, path: &Path) -> Self {
        let (lines, queue) = mpsc::sync_channel::<String>(Self::MOST);
        let problem = Arc::default();
        let writer = {
            let (problem, path) = (Arc::clone(&problem), path.to_owned());
            thread::spawn(move || {
                for line in queue {
                    if let Err(error) = file.write_all(line.as_bytes()) {
                        set(
                            &problem,
                            format!("{}: {error}; the recording ends here", path.display()),
                        );
                        return;
                    }
                }
            })
        };
        Self {
            lines: Some(lines),
            writer: Some(writer),
            problem,
        }
    }

    /// Records a link from now on.
    pub(crate) fn of(&self, link: Box<dyn Link>) -> Box<dyn Link> {
        match &self.lines {
            Some(lines) => Box::new(Recorded {
                link,
                lines: lines.clone(),
                problem: Arc::clone(&self.problem),
            }),
            None => link,
        }
    }

    /// Waits until everything is written, once all recorded links are dropped. Returns what went wrong, if anything.
    pub(crate) fn finish(mut self) -> Option<String> {
        self.lines = None;
        if let Some(writer) = self.writer.take() {
            // The writer has nothing that could panic.
            let _ = writer.join();
        }
        self.problem()
    }

    /// What went wrong so far, if anything.
    pub(crate) fn problem(&self) -> Option<String> {
        self.problem.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

fn set(problem: &Mutex<Option<String>>, words: String) {
    problem
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .get_or_insert(words);
}

/// A link whose bytes are recorded.
struct Recorded {
    link: Box<dyn Link>,
    lines: SyncSender<String>,
    problem: Arc<Mutex<Option<String>>>,
}

impl Recorded {
    fn note<T>(&self, result: &Result<T>, event: char, bytes: &[u8]) {
        let seconds = self.link.now().as_secs_f64();
        let line = match result {
            Ok(_) => format!("{seconds:.6} {event} {}", hex(bytes)),
            Err(error) => format!("{seconds:.6} x {error}"),
        };
        if let Err(TrySendError::Full(_)) = self.lines.try_send(line + "\n") {
            set(&self.problem, "the disk was too slow; the recording has gaps".into());
        }
    }
}

impl Clock for Recorded {
    fn now(&self) -> Duration {
        self.link.now()
    }
}

impl Link for Recorded {
    fn name(&self) -> &str {
        self.link.name()
    }

    fn read(&mut self, buffer: &mut [u8], until: Duration) -> Result<usize> {
        let read = self.link.read(buffer, until);
        self.note(&read, '<', &buffer[..*read.as_ref().unwrap_or(&0)]);
        read
    }

    fn waiting(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let read = self.link.waiting(buffer);
        self.note(&read, '<', &buffer[..*read.as_ref().unwrap_or(&0)]);
        read
    }

    fn write(&mut self, bytes: &[u8], until: Duration) -> Result {
        let written = self.link.write(bytes, until);
        self.note(&written, '>', bytes);
        written
    }

    fn reopen(&mut self) -> Result {
        let opened = self.link.reopen();
        self.note(&opened, 'o', &[]);
        opened
    }
}

/// A recorded link, played back. Each call returns what it returned then; the clock shows the time of then.
#[derive(Debug)]
pub(crate) struct Replay {
    events: std::vec::IntoIter<(Duration, Event)>,
    now: Duration,
}

#[derive(Clone, Debug, PartialEq)]
enum Event {
    Sent(Vec<u8>),
    Received(Vec<u8>),
    Opened,
    Failed(String),
}

impl Replay {
    const NAME: &str = "replay";

    /// Reads a recording of one link.
    ///
    /// # Errors
    /// The line that is not of a recording.
    pub(crate) fn parse(text: &str) -> std::result::Result<Self, String> {
        let mut lines = text.lines().zip(1..);
        if lines.next().is_none_or(|(title, _)| title != TITLE) {
            return Err(format!("line 1: is no recording; allowed: \"{TITLE}\""));
        }
        let events: std::result::Result<Vec<_>, String> = lines
            .map(|(line, number)| event(line).ok_or_else(|| format!("line {number}: \"{line}\" is no event of a link")))
            .collect();
        Ok(Self {
            events: events?.into_iter(),
            now: Duration::ZERO,
        })
    }

    /// Whether all of it has been played.
    pub(crate) fn is_over(&self) -> bool {
        self.events.len() == 0
    }

    /// The next event, which must be what the recording has.
    fn next(&mut self, asked: &str) -> Result<Event> {
        let (at, event) = self.events.next().ok_or_else(|| Error::Disconnected {
            link: Self::NAME.into(),
            cause: format!("the recording ends here, before {asked}"),
        })?;
        self.now = at;
        match event {
            Event::Failed(cause) => Err(Error::Disconnected {
                link: Self::NAME.into(),
                cause,
            }),
            event => Ok(event),
        }
    }

    fn departed(&self, asked: &str, event: &Event) -> Error {
        Error::Disconnected {
            link: Self::NAME.into(),
            cause: format!("at {:?} the recording has {event:?} and not {asked}", self.now),
        }
    }
}

fn event(line: &str) -> Option<(Duration, Event)> {
    let (seconds, rest) = line.split_once(' ')?;
    let at = Duration::try_from_secs_f64(seconds.parse().ok()?).ok()?;
    let (what, rest) = rest.split_once(' ')?;
    let event = match what {
        ">" => Event::Sent(bytes(rest)?),
        "<" => Event::Received(bytes(rest)?),
        "o" => Event::Opened,
        "x" => Event::Failed(rest.into()),
        _ => return None,
    };
    Some((at, event))
}

fn hex(bytes: &[u8]) -> String {
    let digits = bytes.iter().flat_map(|byte| [byte >> 4, byte & 15]);
    digits.filter_map(|digit| char::from_digit(digit.into(), 16)).collect()
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
        Self::NAME
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
            event => Err(self.departed("a read", &event)),
        }
    }

    fn write(&mut self, bytes: &[u8], _: Duration) -> Result {
        match self.next("a write")? {
            Event::Sent(sent) if sent == bytes => Ok(()),
            event => Err(self.departed(&format!("{:?}", Event::Sent(bytes.into())), &event)),
        }
    }

    fn reopen(&mut self) -> Result {
        match self.next("opening")? {
            Event::Opened => Ok(()),
            event => Err(self.departed("opening", &event)),
        }
    }
}

#[cfg(test)]
mod tests;
