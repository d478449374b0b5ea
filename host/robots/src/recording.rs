//! Recordings of links: all bytes with their time and direction, as text. A bug report carries one, and a test replays
//! it: a driver decides only by its link's data, so it does the same again.
//!
//! A line for each link says its address, `=`; then there is one for each call to it: seconds, what happened, and the bytes
//! in hexadecimal. `>` bytes sent, `<` bytes received (none: waited in vain), `o` opened again, `x` failed, with the error in
//! JSON; `+` a stop that the guard has repeated. A file has several links if several are tried, one after the other.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::mpsc::{self, SyncSender, TrySendError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use oneiro_base::plain;
use serde_json::json;

use super::error::Result;
use super::link::{Clock, Link};

const TITLE: &str = "oneiro link recording 1";

/// A file that links are recorded to. A thread writes it: a slow or full disk must not hold a robot.
#[derive(Debug)]
pub struct Recording {
    lines: Option<SyncSender<String>>,
    writer: Option<JoinHandle<()>>,
    problem: Arc<Mutex<Option<String>>>,
}

impl Recording {
    /// Lines that wait for the disk; more are lost.
    const MOST: usize = 2000;
    /// Bytes of a file: days of any robot, and an end for one that sends without end.
    const LONGEST: u64 = 1 << 30;

    /// Starts a recording in a new file.
    ///
    /// # Errors
    /// The file exists, or can't be written.
    pub fn create(path: &Path) -> std::io::Result<Self> {
        let mut file = plain::create(path)?;
        writeln!(file, "{TITLE}")?;
        Ok(Self::to(file, path, Self::LONGEST))
    }

    /// Starts a recording of at most so many bytes in a file that has its title.
    fn to(mut file: File, path: &Path, longest: u64) -> Self {
        let (lines, queue) = mpsc::sync_channel::<String>(Self::MOST);
        let problem = Arc::default();
        let writer = {
            let (problem, path) = (Arc::clone(&problem), path.to_owned());
            thread::spawn(move || {
                let mut left = longest;
                for line in queue {
                    let written = match left.checked_sub(line.len() as u64) {
                        Some(rest) => file.write_all(line.as_bytes()).map(|()| left = rest),
                        None => Err(std::io::Error::other(format!(
                            "has {longest} bytes, as many as are recorded"
                        ))),
                    };
                    if let Err(error) = written {
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
    pub fn of(&self, link: Box<dyn Link>) -> Box<dyn Link> {
        let Some(lines) = &self.lines else { return link };
        let recorded = Recorded {
            link,
            lines: lines.clone(),
            problem: Arc::clone(&self.problem),
        };
        recorded.write_line('=', recorded.name());
        Box::new(recorded)
    }

    /// A recorder of the guard's repeated stops.
    pub fn aside(&self) -> Option<Aside> {
        self.lines.clone().map(Aside)
    }

    /// Waits until everything is written, once all recorded links are dropped. Returns what went wrong, if anything.
    pub fn finish(mut self) -> Option<String> {
        self.lines = None;
        if let Some(writer) = self.writer.take() {
            // The writer has nothing that could panic.
            let _ = writer.join();
        }
        self.problem()
    }

    /// What went wrong so far, if anything.
    pub fn problem(&self) -> Option<String> {
        self.problem.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

fn set(problem: &Mutex<Option<String>>, words: String) {
    problem
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .get_or_insert(words);
}

/// Records the guard's repeated stops.
#[derive(Debug)]
pub struct Aside(SyncSender<String>);

impl Aside {
    /// A stop was sent at a time.
    pub fn sent(&self, at: Duration, bytes: &[u8]) {
        // Where the disk is too slow for it, the driver's own bytes show that.
        let _ = self.0.try_send(format!("{:.6} + {}\n", at.as_secs_f64(), hex(bytes)));
    }
}

/// A link whose bytes are recorded.
struct Recorded {
    link: Box<dyn Link>,
    lines: SyncSender<String>,
    problem: Arc<Mutex<Option<String>>>,
}

impl Recorded {
    fn write_line(&self, event: char, rest: &str) {
        let line = format!("{:.6} {event} {rest}\n", self.link.now().as_secs_f64());
        if let Err(TrySendError::Full(_)) = self.lines.try_send(line) {
            set(&self.problem, "the disk was too slow; the recording has gaps".into());
        }
    }

    fn note<T>(&self, result: &Result<T>, event: char, bytes: &[u8]) {
        match result {
            Ok(_) => self.write_line(event, &hex(bytes)),
            Err(error) => self.write_line('x', &json!(error).to_string()),
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

    fn delay(&self) -> Duration {
        self.link.delay()
    }

    fn reopen(&mut self) -> Result {
        let opened = self.link.reopen();
        self.note(&opened, 'o', &[]);
        opened
    }
}

fn hex(bytes: &[u8]) -> String {
    let digits = bytes.iter().flat_map(|byte| [byte >> 4, byte & 15]);
    digits.filter_map(|digit| char::from_digit(digit.into(), 16)).collect()
}

#[cfg(any(test, feature = "testing"))]
pub mod replay;
#[cfg(test)]
mod tests;
