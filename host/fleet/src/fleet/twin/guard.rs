//! A guard's side of a twin: a coroutine in the conductor's thread, since it has far more turns than a daemon. It
//! outlives its daemon, as a guard's process does.

#![expect(
    deprecated,
    reason = "what came instead borrows from the coroutine, and a driver's link may not borrow"
)]

use std::io;
use std::sync::Arc;
use std::time::Duration;

use generator::{Generator, Gn};
use oneiro_robots::Kind;
use oneiro_robots::error::{Error, Result};
use oneiro_robots::guard::alone::{self, Pipe};
use oneiro_robots::guard::message::Report;
use oneiro_robots::guard::values::Values;
use oneiro_robots::guard::wheels::Wanted;
use oneiro_robots::link::{Clock, Link};

use super::lockstep::{Conducted, Lockstep};
use super::wire::{Time, Up};

/// A robot's guard.
pub(super) struct Guard(Generator<'static, Time, Vec<Up>>);

impl Guard {
    /// A guard with these values, which waits for the time.
    pub(super) fn new(robot: u32, values: &Values) -> Self {
        /// Of a stack, in words of 8 bytes.
        const STACK: usize = 1 << 16;
        let values = values.clone();
        Self(Gn::new_opt(STACK, move || {
            let Some(time) = generator::get_yield() else {
                return Vec::new();
            };
            let lockstep = Lockstep::new(Box::new(Coroutine), time, Arc::default());
            let line = Line {
                lockstep: lockstep.clone(),
                name: format!("twin:{robot}"),
            };
            let wanted = Wanted {
                kinds: vec![Kind::Proximity, Kind::Light],
                odometry: false,
            };
            alone::guard(Box::new(line), &lockstep, &wanted, &values);
            std::mem::take(&mut lockstep.lock().said)
        }))
    }

    /// Gives it time. Returns its messages: the last one is a wait, unless it has ended.
    pub(super) fn turn(&mut self, time: Time) -> Vec<Up> {
        if self.0.is_done() {
            Vec::new()
        } else {
            self.0.send(time)
        }
    }

    /// Gives it no more time: it ends without waiting.
    pub(super) fn close(mut self) {
        if !self.0.is_done() {
            self.0.raw_send(None);
        }
    }
}

/// The coroutine's connection with the conductor.
struct Coroutine;

impl Conducted for Coroutine {
    fn wait(&mut self, said: Vec<Up>) -> io::Result<Time> {
        generator::yield_(said).ok_or_else(|| io::ErrorKind::ConnectionAborted.into())
    }

    /// The coroutine returns it.
    fn leave(&mut self, _: Vec<Up>) {}
}

/// The serial line.
struct Line {
    lockstep: Lockstep,
    name: String,
}

impl Clock for Line {
    fn now(&self) -> Duration {
        self.lockstep.now()
    }
}

impl Link for Line {
    fn name(&self) -> &str {
        &self.name
    }

    fn read(&mut self, buffer: &mut [u8], until: Duration) -> Result<usize> {
        let mut shared = self.lockstep.lock();
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
        let mut shared = self.lockstep.lock();
        let count = buffer.len().min(shared.line.len());
        for (place, byte) in buffer.iter_mut().zip(shared.line.drain(..count)) {
            *place = byte;
        }
        Ok(count)
    }

    fn write(&mut self, bytes: &[u8], _: Duration) -> Result {
        self.lockstep.say(Up::Line(bytes.to_vec()));
        Ok(())
    }

    fn reopen(&mut self) -> Result {
        let mut shared = self.lockstep.lock();
        shared.line.clear();
        shared.said.push(Up::Reopen);
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
        self.say(Up::Tell(line));
    }

    fn wait(&self, until: Duration) {
        self.lock().wait(until, false, true);
    }
}
