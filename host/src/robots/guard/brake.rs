//! The brake: ends a driver's waiting, so that a stop comes at once.
//!
//! A driver waits up to 1.5 s for an answer, and longer while it gets back in step. A stop can't wait for that, and a
//! driver begins each stop by sending it; so the guard ends the call in progress and calls again.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use crate::robots::error::{Error, Result};
use crate::robots::link::{Clock, Link};

/// Ends the waiting of all links that it was put on. Its clones are the same brake.
#[derive(Clone, Debug)]
pub(crate) struct Brake(Arc<AtomicU64>);

impl Default for Brake {
    /// A brake that is released.
    fn default() -> Self {
        Self(Arc::new(AtomicU64::new(u64::MAX)))
    }
}

impl Brake {
    /// How long the brake may take to act.
    const GLANCE: Duration = Duration::from_millis(20);

    /// A link with this brake.
    pub(crate) fn on(&self, link: Box<dyn Link>) -> Box<dyn Link> {
        Box::new(Braked {
            link,
            brake: self.clone(),
        })
    }

    /// Ends all waiting, now and from now on.
    pub(super) fn press(&self) {
        self.0.store(0, Ordering::SeqCst);
    }

    /// Allows waiting until a time on the links' clock; for ever without one.
    pub(super) fn release(&self, until: Option<Duration>) {
        let until = until.map_or(u64::MAX, |until| until.as_micros() as u64);
        self.0.store(until, Ordering::SeqCst);
    }

    fn acts(&self, now: Duration) -> bool {
        now.as_micros() as u64 >= self.0.load(Ordering::SeqCst)
    }
}

/// A link with a brake. Only waiting for bytes is ended, never a write: half a command would do harm.
struct Braked {
    link: Box<dyn Link>,
    brake: Brake,
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
            match self.link.read(buffer, until.min(now + Brake::GLANCE))? {
                0 if self.now() < until => {}
                count => return Ok(count),
            }
        }
    }

    fn waiting(&mut self, buffer: &mut [u8]) -> Result<usize> {
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
    use crate::robots::khepera::Khepera;
    use crate::robots::script::{Scripted, hear, say, say_after};
    use crate::robots::{Kind, Robot};

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
        let mut robot = Khepera::new(brake.on(Box::new(script)));
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
