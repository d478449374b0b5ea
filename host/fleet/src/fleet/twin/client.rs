//! A daemon's side of a twin: a process whose guard and datagrams are the conductor's.

use std::io;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use oneiro_base::console::{Console, Output};
use oneiro_base::exit::Failure;
use oneiro_robots::guard::client::Lost;
use oneiro_robots::guard::message::{self, Report, Request};
use oneiro_robots::link::Clock;
use oneiro_robots::vehicle::Vehicle;
use oneiro_robots::vehicle::guarded::{Connection, Guarded};

use super::lockstep::{Conducted, Lockstep};
use super::wire::{Port, Time, Up, VERSION};
use crate::daemon::air::{Air, Channel};

/// A robot, and what carries a daemon's datagrams.
pub type Connected = (Box<dyn Vehicle + Send>, Box<dyn Air>);

/// Connects a daemon with the conductor: its robot behind a guard, and its datagrams. `stop` is set when the experiment is over; set by
/// anyone, it ends all waiting.
///
/// # Errors
/// Exit 4: no conductor is there, or the robot does not answer.
pub fn connect(path: &Path, robot: u32, stop: Arc<AtomicBool>) -> Result<Connected, Failure> {
    let lost = |error: io::Error| Failure::device(format_args!("--conductor {}: {error}", path.display()));
    let mut port = Port::new(UnixStream::connect(path).map_err(lost)?);
    let version = VERSION;
    port.send(&[Up::Hello { version, robot }]).map_err(lost)?;
    let time = port.receive().map_err(lost)?;
    let lockstep = Lockstep::new(Box::new(port), time, Arc::clone(&stop));
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

impl Conducted for Port {
    fn wait(&mut self, said: Vec<Up>) -> io::Result<Time> {
        self.send(&said)?;
        self.receive()
    }

    fn leave(&mut self, said: Vec<Up>) {
        let _ = self.send(&said);
    }
}

impl Air for Lockstep {
    fn send(&mut self, datagram: &[u8]) {
        self.say(Up::Send(datagram.to_vec()));
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
        self.lockstep.say(Up::Tell(line));
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

    fn report_within(&mut self, limit: Duration) -> Result<Option<(Duration, Report)>, Lost> {
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
        /// A guard may need as long to stop a robot that does not answer.
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
