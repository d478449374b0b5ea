//! What the conductor gives time to, as itself sees it: daemons, which are processes, and guards, which are coroutines.

use std::collections::VecDeque;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use oneiro_robots::link::Clock;

use super::wire::{Time, Up};
use crate::daemon::air::Channel;

/// What connects a participant with the conductor.
pub(super) trait Conducted: Send {
    /// Says something that ends with a wait, and waits.
    ///
    /// # Errors
    /// The conductor is gone.
    fn wait(&mut self, said: Vec<Up>) -> io::Result<Time>;

    /// Says something before the participant ends. Nobody may be there any more.
    fn leave(&mut self, said: Vec<Up>);
}

/// A participant's clock, and what has come for it. Its clones share it.
#[derive(Clone)]
pub(super) struct Lockstep(Arc<Mutex<Shared>>);

pub(super) struct Shared {
    conductor: Box<dyn Conducted>,
    /// Messages to send with the next wait.
    pub(super) said: Vec<Up>,
    pub(super) now: Duration,
    /// Bytes from the robot.
    pub(super) line: VecDeque<u8>,
    /// Lines from the other of daemon and guard.
    pub(super) told: VecDeque<String>,
    pub(super) datagrams: VecDeque<(Channel, Vec<u8>)>,
    /// Whether the other of daemon and guard is gone.
    pub(super) closed: bool,
    /// Whether the conductor is gone.
    pub(super) lost: bool,
    /// Set when the experiment is over.
    ended: Arc<AtomicBool>,
}

impl Shared {
    /// Takes the conductor's message.
    fn take(&mut self, time: Time) {
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
    }

    /// Waits until a moment; with `line` until bytes come from the robot, with `told` until a line comes.
    pub(super) fn wait(&mut self, until: Duration, line: bool, told: bool) {
        if until <= self.now {
            return;
        }
        self.said.push(Up::Wait {
            until: until.as_nanos() as u64,
            line,
            told,
        });
        let said = std::mem::take(&mut self.said);
        let time = if self.lost {
            None
        } else {
            self.conductor.wait(said).ok()
        };
        if let Some(time) = time {
            self.take(time);
        } else {
            // Without the conductor nothing comes any more, and waits must end.
            (self.lost, self.closed, self.now) = (true, true, until);
        }
    }
}

impl Drop for Shared {
    /// The last messages still count.
    fn drop(&mut self) {
        self.conductor.leave(std::mem::take(&mut self.said));
    }
}

impl Lockstep {
    /// A participant that has been given this time. `ended` is set when the experiment is over.
    pub(super) fn new(conductor: Box<dyn Conducted>, time: Time, ended: Arc<AtomicBool>) -> Self {
        let mut shared = Shared {
            conductor,
            said: Vec::new(),
            now: Duration::ZERO,
            line: VecDeque::new(),
            told: VecDeque::new(),
            datagrams: VecDeque::new(),
            closed: false,
            lost: false,
            ended,
        };
        shared.take(time);
        Self(Arc::new(Mutex::new(shared)))
    }

    pub(super) fn say(&self, message: Up) {
        self.lock().said.push(message);
    }

    pub(super) fn lock(&self) -> MutexGuard<'_, Shared> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Clock for Lockstep {
    fn now(&self) -> Duration {
        self.lock().now
    }
}
