//! A link on a virtual clock to a Khepera that is emulated by the protocol's description, and what can go wrong on the way.
//! For tests.

#[path = "../../../tests/peers/khepera.rs"]
#[allow(dead_code, reason = "tests of the program use the rest")]
pub mod khepera;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use super::error::{Error, Result};
use super::link::{Clock, Link};
use super::vehicle::direct::Hand;
use khepera::{Body, Khepera};

/// Bytes with the times of their arrival.
type Timed = Vec<(Duration, u8)>;
/// Changes what is sent in one direction at once.
type Change<T> = Box<dyn FnMut(T) -> T + Send>;

/// A robot and its line.
pub struct Line<B> {
    pub robot: Khepera<B>,
    now: Duration,
    /// What is on the way to the program, in the order of arrival.
    coming: VecDeque<(Duration, u8)>,
    /// Changes what the program sends.
    outwards: Change<Vec<u8>>,
    /// Changes what the robot sends.
    inwards: Change<Timed>,
    /// Whether the program receives its own bytes, as on a shared wire.
    echoes: bool,
    is_open: bool,
    can_open: bool,
    /// The most bytes that one read returns.
    chunk: usize,
}

impl<B: Body> Line<B> {
    /// Runs the robot until now, and takes its bytes.
    fn collect(&mut self) {
        self.robot.live(self.now);
        let said = self.robot.timed();
        if !said.is_empty() {
            let said = (self.inwards)(said);
            self.queue(said);
        }
    }

    /// Sends bytes to the program. None overtakes another.
    fn queue(&mut self, timed: impl IntoIterator<Item = (Duration, u8)>) {
        for (at, byte) in timed {
            let last = self.coming.back().map_or(at, |(last, _)| *last);
            self.coming.push_back((at.max(last), byte));
        }
    }

    /// Restarts the robot. Its message is cut off.
    fn restart(&mut self) {
        self.collect();
        let now = self.now;
        self.coming.retain(|(at, _)| *at <= now);
        self.robot.restart(now);
    }

    /// Says bytes that the robot does not, now.
    fn inject(&mut self, bytes: &[u8]) {
        let now = self.now;
        self.queue(bytes.iter().map(|byte| (now, *byte)));
    }
}

/// The program's end of a line, and a test's hand on the other end.
pub struct Bench<B>(Arc<Mutex<Line<B>>>);

impl<B> Clone for Bench<B> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<B: Body> Bench<B> {
    pub fn new(robot: Khepera<B>) -> Self {
        Self(Arc::new(Mutex::new(Line {
            robot,
            now: Duration::from_secs(100),
            coming: VecDeque::new(),
            outwards: Box::new(|bytes| bytes),
            inwards: Box::new(|timed| timed),
            echoes: false,
            is_open: true,
            can_open: true,
            chunk: usize::MAX,
        })))
    }

    pub fn line(&self) -> MutexGuard<'_, Line<B>> {
        self.0.lock().unwrap()
    }

    /// Lets time pass.
    fn pass(&self, ms: u64) {
        let mut line = self.line();
        line.now += Duration::from_millis(ms);
        line.collect();
    }

    fn closed(&self) -> Error {
        Error::Disconnected {
            link: self.name().into(),
            cause: "unplugged".into(),
        }
    }

    fn open(&self) -> Result<MutexGuard<'_, Line<B>>> {
        let line = self.line();
        if line.is_open { Ok(line) } else { Err(self.closed()) }
    }
}

impl<B> Clock for Bench<B> {
    fn now(&self) -> Duration {
        self.0.lock().unwrap().now
    }
}

impl<B: Body> Hand for Bench<B> {
    fn pass_until(&mut self, until: Duration) {
        let mut line = self.line();
        line.now = line.now.max(until);
        line.collect();
    }
}

impl<B: Body> Link for Bench<B> {
    fn name(&self) -> &'static str {
        "bench"
    }

    fn read(&mut self, buffer: &mut [u8], until: Duration) -> Result<usize> {
        let mut line = self.open()?;
        if until <= line.now {
            return Ok(0);
        }
        line.collect();
        // Reads end when the time has come, even if a byte comes at the same moment.
        let next = line.coming.front().map(|(at, _)| *at).filter(|at| *at < until);
        line.now = next.map_or(until, |at| at.max(line.now));
        drop(line);
        if next.is_some() { self.waiting(buffer) } else { Ok(0) }
    }

    fn waiting(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let mut line = self.open()?;
        line.collect();
        let now = line.now;
        let come = line.coming.iter().take_while(|(at, _)| *at <= now).count();
        let count = come.min(buffer.len()).min(line.chunk);
        for (place, (_, byte)) in buffer.iter_mut().zip(line.coming.drain(..count)) {
            *place = byte;
        }
        Ok(count)
    }

    fn write(&mut self, bytes: &[u8], _: Duration) -> Result {
        let mut line = self.open()?;
        line.collect();
        let now = line.now;
        if line.echoes {
            let time = line.robot.byte_time();
            line.queue((1..).zip(bytes).map(|(count, byte)| (now + count * time, *byte)));
        }
        let bytes = (line.outwards)(bytes.to_vec());
        line.robot.receive(&bytes, now);
        line.collect();
        Ok(())
    }

    fn reopen(&mut self) -> Result {
        let mut line = self.line();
        line.coming.clear();
        line.is_open = line.can_open;
        if line.is_open {
            return Ok(());
        }
        Err(Error::Unavailable {
            link: "bench".into(),
            cause: "no such port".into(),
            advice: "plug it in".into(),
        })
    }
}
