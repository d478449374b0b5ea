//! The side of those whom the conductor gives time. On one connection: the clock, the serial line and the program of a guard, or the
//! guard and the datagrams of a daemon.

use std::collections::VecDeque;
use std::io;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::wire::{Port, Time, Up, VERSION};
use crate::console::{Console, Output};
use crate::daemon::air::{Air, Channel};
use crate::exit::Failure;
use crate::robots::error::{Error, Result};
use crate::robots::guard::alone::Pipe;
use crate::robots::guard::client::Lost;
use crate::robots::guard::message::{self, Report, Request};
use crate::robots::link::{Clock, Link};
use crate::robots::vehicle::Vehicle;
use crate::robots::vehicle::guarded::{Connection, Guarded};

/// A robot, and what carries a daemon's datagrams.
pub(crate) type Connected = (Box<dyn Vehicle + Send>, Box<dyn Air>);

/// Connects a daemon with the conductor: its robot behind a guard, and its datagrams. `stop` is set when the experiment is over; set by
/// anyone, it ends all waiting.
///
/// # Errors
/// Exit 4: no conductor is there, or the robot does not answer.
pub(crate) fn connect(path: &Path, robot: u32, stop: Arc<AtomicBool>) -> std::result::Result<Connected, Failure> {
    let lost = |error: io::Error| Failure::device(format_args!("--conductor {}: {error}", path.display()));
    let stream = UnixStream::connect(path).map_err(lost)?;
    let lockstep = Lockstep::begin(stream, robot, Arc::clone(&stop)).map_err(lost)?;
    let mut guard = Steered {
        lockstep: lockstep.clone(),
        sequence: 0,
    };
    guard.send(Request::Hello {
        version: message::VERSION,
    });
    let quiet = Console::new(Output {
        quiet: true,
        ..Output::default()
    });
    let vehicle = Guarded::behind(Box::new(guard), false, stop, quiet)?;
    Ok((Box::new(vehicle), Box::new(lockstep)))
}

/// A connection with the conductor. Its clones share it.
#[derive(Clone)]
pub(super) struct Lockstep {
    shared: Arc<Mutex<Shared>>,
    name: Arc<str>,
}

struct Shared {
    port: Port,
    now: Duration,
    line: VecDeque<u8>,
    told: VecDeque<String>,
    datagrams: VecDeque<(Channel, Vec<u8>)>,
    /// Whether the other of daemon and guard is gone.
    closed: bool,
    /// Whether the conductor is gone.
    lost: bool,
    /// Set when the experiment is over.
    ended: Arc<AtomicBool>,
}

impl Shared {
    /// Takes what the conductor says next.
    fn take(&mut self) -> io::Result<()> {
        let time: Time = self.port.receive()?;
        self.now = self.now.max(Duration::from_nanos(time.now));
        self.line.extend(time.line);
        self.told.extend(time.told);
        self.closed |= time.closed;
        if time.ended {
            self.ended.store(true, Ordering::Relaxed);
        }
        self.datagrams
            .extend(time.datagrams.into_iter().map(|(is_tracker, bytes)| {
                let channel = if is_tracker { Channel::Tracker } else { Channel::Radio };
                (channel, bytes)
            }));
        Ok(())
    }

    fn wait(&mut self, until: Duration, line: bool, told: bool) {
        if until <= self.now {
            return;
        }
        let wait = Up::Wait {
            until: until.as_nanos() as u64,
            line,
            told,
        };
        if self.lost || self.port.send(&wait).and_then(|()| self.take()).is_err() {
            // Without the conductor nothing comes any more, and whoever waits must get on.
            (self.lost, self.closed, self.now) = (true, true, until);
        }
    }
}

impl Drop for Shared {
    /// What was said last still counts.
    fn drop(&mut self) {
        self.port.flush();
    }
}

impl Lockstep {
    /// Says who it is, and waits for the time.
    ///
    /// # Errors
    /// The conductor is gone.
    pub(super) fn begin(stream: UnixStream, robot: u32, ended: Arc<AtomicBool>) -> io::Result<Self> {
        let mut shared = Shared {
            port: Port::new(stream),
            now: Duration::ZERO,
            line: VecDeque::new(),
            told: VecDeque::new(),
            datagrams: VecDeque::new(),
            closed: false,
            lost: false,
            ended,
        };
        let version = VERSION;
        shared.port.send(&Up::Hello { version, robot })?;
        shared.take()?;
        Ok(Self {
            shared: Arc::new(Mutex::new(shared)),
            name: format!("twin:{robot}").into(),
        })
    }

    fn lock(&self) -> MutexGuard<'_, Shared> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Clock for Lockstep {
    fn now(&self) -> Duration {
        self.lock().now
    }
}

impl Link for Lockstep {
    fn name(&self) -> &str {
        &self.name
    }

    fn read(&mut self, buffer: &mut [u8], until: Duration) -> Result<usize> {
        let mut shared = self.lock();
        if until <= shared.now {
            return Ok(0);
        }
        while shared.line.is_empty() && shared.now < until {
            shared.wait(until, true, false);
            if shared.lost {
                drop(shared);
                return Err(gone(&self.name));
            }
        }
        drop(shared);
        self.waiting(buffer)
    }

    fn waiting(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let mut shared = self.lock();
        let count = buffer.len().min(shared.line.len());
        for (place, byte) in buffer.iter_mut().zip(shared.line.drain(..count)) {
            *place = byte;
        }
        Ok(count)
    }

    fn write(&mut self, bytes: &[u8], _: Duration) -> Result {
        self.lock().port.add(&Up::Line(bytes.to_vec()));
        Ok(())
    }

    fn reopen(&mut self) -> Result {
        let mut shared = self.lock();
        shared.line.clear();
        shared.port.add(&Up::Reopen);
        if shared.lost { Err(gone(&self.name)) } else { Ok(()) }
    }
}

fn gone(name: &str) -> Error {
    Error::Disconnected {
        link: name.into(),
        cause: "the conductor is gone".into(),
    }
}

impl Pipe for Lockstep {
    fn lines(&self) -> Vec<String> {
        self.lock().told.drain(..).collect()
    }

    fn is_closed(&self) -> bool {
        self.lock().closed
    }

    fn report(&self, report: &Report) {
        let line = serde_json::to_string(report).unwrap_or_default();
        self.lock().port.add(&Up::Tell(line));
    }

    fn wait(&self, until: Duration) {
        self.lock().wait(until, false, true);
    }
}

impl Air for Lockstep {
    fn send(&mut self, datagram: &[u8]) {
        self.lock().port.add(&Up::Send(datagram.to_vec()));
    }

    fn receive(&mut self) -> Option<(Channel, Vec<u8>)> {
        self.lock().datagrams.pop_front()
    }
}

/// A daemon's connection with the guard.
struct Steered {
    lockstep: Lockstep,
    sequence: u64,
}

impl Connection for Steered {
    fn now(&self) -> Duration {
        self.lockstep.now()
    }

    fn send(&mut self, request: Request) {
        let line = serde_json::to_string(&request).unwrap_or_default();
        self.lockstep.lock().port.add(&Up::Tell(line));
    }

    fn drive(&mut self, [left_mm_s, right_mm_s]: [f64; 2]) {
        self.sequence += 1;
        self.send(Request::Command {
            sequence: self.sequence,
            left_mm_s,
            right_mm_s,
        });
    }

    fn sequence(&self) -> u64 {
        self.sequence
    }

    fn report_within(&mut self, limit: Duration) -> std::result::Result<Option<(Duration, Report)>, Lost> {
        let mut shared = self.lockstep.lock();
        if shared.told.is_empty() && !shared.closed {
            let until = shared.now + limit;
            shared.wait(until, false, true);
        }
        let now = shared.now;
        match shared.told.pop_front() {
            Some(line) => Ok(serde_json::from_str(&line).ok().map(|report| (now, report))),
            None if shared.closed => Err(Lost::Ended),
            None => Ok(None),
        }
    }

    fn without(self: Box<Self>, lost: Lost, _: Console) -> Failure {
        Failure::device(format_args!("{lost}, and nothing else reaches the robot"))
    }

    fn leave(mut self: Box<Self>, _: Console) -> Option<String> {
        /// A guard may take as long to stop a robot that does not answer.
        const LIMIT: Duration = Duration::from_mins(1);
        self.send(Request::End);
        let until = self.now() + LIMIT;
        let mut failed = None;
        while self.now() < until {
            match self.report_within(until.saturating_sub(self.now())) {
                Ok(Some((_, Report::Failed { message, .. }))) => failed = Some(message),
                Ok(_) => {}
                Err(_) => return failed,
            }
        }
        Some("the guard has not stopped the robot in time".into())
    }
}
