//! The brake ends a driver's waiting, so that a stop comes at once, and repeats the stop until the robot has confirmed
//! it.
//!
//! A driver waits up to 1.5 s for an answer, and longer while it gets back in step. A stop can't wait for that, and a
//! driver begins each stop by sending it; so the guard ends the call in progress and calls again. From then on a
//! separate timer repeats the stop, even while the driver waits: all its waiting is here.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::error::{Error, Result};
use crate::link::{self, Clock, Link};
use crate::recording::Aside;

/// Ends the waiting of all links that it was put on, and repeats stops there. Its clones are the same brake.
#[derive(Clone, Debug)]
pub struct Brake(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    /// When waiting ends, in microseconds.
    ends: AtomicU64,
    /// The stop that is repeated, and when it was sent last.
    stop: Mutex<Option<(Vec<u8>, Duration)>>,
}

impl Default for Brake {
    /// A brake that is released.
    fn default() -> Self {
        Self(Arc::new(Shared {
            ends: AtomicU64::new(u64::MAX),
            stop: Mutex::default(),
        }))
    }
}

impl Brake {
    /// How long the brake may take to act.
    const GLANCE: Duration = Duration::from_millis(20);
    /// Time between two stops without a confirmation: at most 250 ms with a margin for a busy computer.
    const REPEAT: Duration = Duration::from_millis(150);
    /// How long the link may take for a stop.
    const SEND: Duration = Duration::from_millis(200);

    /// A link with this brake. `aside` records the stops that it repeats.
    pub fn on(&self, link: Box<dyn Link>, aside: Option<Aside>) -> Box<dyn Link> {
        Box::new(Braked {
            link,
            brake: self.clone(),
            aside,
        })
    }

    /// Repeats a stop from now on, which the driver is about to send for the first time.
    pub(super) fn repeat(&self, stop: Vec<u8>, now: Duration) {
        let mut repeated = self.repeated();
        let since = repeated.as_ref().map_or(now, |(_, last)| *last);
        *repeated = Some((stop, since));
    }

    /// Stops repeating it.
    pub(super) fn rest(&self) {
        *self.repeated() = None;
    }

    fn repeated(&self) -> MutexGuard<'_, Option<(Vec<u8>, Duration)>> {
        self.0.stop.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends all waiting, now and from now on.
    pub(super) fn press(&self) {
        self.0.ends.store(0, Ordering::SeqCst);
    }

    /// Allows waiting until a time on the links' clock; for ever without one.
    pub(super) fn release(&self, until: Option<Duration>) {
        let until = until.map_or(u64::MAX, |until| until.as_micros() as u64);
        self.0.ends.store(until, Ordering::SeqCst);
    }

    fn acts(&self, now: Duration) -> bool {
        now.as_micros() as u64 >= self.0.ends.load(Ordering::SeqCst)
    }
}

/// A link with a brake. Only waiting for bytes is ended, never a write: half a command would do harm. For the same reason stops
/// are repeated whole, between two writes.
struct Braked {
    link: Box<dyn Link>,
    brake: Brake,
    aside: Option<Aside>,
}

impl Braked {
    /// Sends the stop again if it is time to. Returns when that is next, if it is repeated.
    fn remind(&mut self) -> Result<Option<Duration>> {
        let mut repeated = self.brake.repeated();
        let Some((stop, last)) = &mut *repeated else {
            return Ok(None);
        };
        if self.link.now() >= *last + Brake::REPEAT {
            let sent = link::send_whole(&mut *self.link, stop, Brake::SEND);
            *last = self.link.now();
            if let (Some(aside), Ok(())) = (&self.aside, &sent) {
                aside.sent(*last, stop);
            }
            sent?;
        }
        Ok(Some(*last + Brake::REPEAT))
    }
}

impl Clock for Braked {
    fn now(&self) -> Duration {
        self.link.now()
    }
}

impl Link for Braked {
    fn name(&self) -> &str {
        self.link.name()
    }

    fn read(&mut self, buffer: &mut [u8], until: Duration) -> Result<usize> {
        loop {
            let now = self.now();
            if self.brake.acts(now) {
                return Err(Error::Interrupted);
            }
            let next = self.remind()?.unwrap_or(until);
            match self.link.read(buffer, until.min(now + Brake::GLANCE).min(next))? {
                0 if self.now() < until => {}
                count => return Ok(count),
            }
        }
    }

    fn waiting(&mut self, buffer: &mut [u8]) -> Result<usize> {
        self.remind()?;
        self.link.waiting(buffer)
    }

    fn write(&mut self, bytes: &[u8], until: Duration) -> Result {
        self.link.write(bytes, until)
    }

    fn reopen(&mut self) -> Result {
        self.link.reopen()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::khepera::Khepera;
    use crate::script::{Scripted, hear, say, say_after};
    use crate::{Kind, Robot};

    /// A reading whose answer does not come is ended after a moment, and the stop is sent at once; the late answer is no
    /// answer to it.
    #[test]
    fn a_stop_need_not_wait_for_an_answer() {
        let brake = Brake::default();
        let script = Scripted::new([
            hear("\rD,0,0\r"),
            say("d\r\n"),
            hear("B\r"),
            say("b,5.02,5.01\r\n"),
            hear("D,0,0\r"),
            say("d\r\n"),
            hear("E\r"),
            say("e,0,0\r\n"),
            hear("N\r"),
            hear("\rD,0,0\r"),
            hear("\rD,0,0\r"),
            say("n,1,2,3,4,5,6,7,8\r\n"),
            say_after(0, "d\r\nd\r\n"),
            hear("B\r"),
            say("b,5.02,5.01\r\n"),
            hear("D,0,0\r"),
            say("d\r\n"),
            hear("E\r"),
            say("e,0,0\r\n"),
        ]);
        let hand = script.hand();
        let mut robot = Khepera::new(brake.on(Box::new(script), None));
        robot.begin().unwrap();
        brake.release(Some(hand.now() + Duration::from_millis(30)));
        let start = hand.now();
        let kinds = [Kind::Proximity];
        assert_eq!(robot.sense(&kinds), Err(Error::Interrupted));
        assert!(hand.now() <= start + Duration::from_millis(30) + Brake::GLANCE);
        brake.press();
        let start = hand.now();
        assert_eq!(robot.sense(&kinds), Err(Error::Interrupted));
        assert_eq!(hand.now(), start);
        brake.release(None);
        robot.stop().unwrap();
    }
}
