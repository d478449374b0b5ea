//! Batches on their way to the device and back, and what ends their work.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::Duration;

use oneiro::batch::{Batch, Outcome};
use oneiro::evaluator::{Control, Error};
use oneiro::parameter::Invalid;

use super::watcher::Watch;
use crate::exit::Failure;

/// What ends work on a device early.
#[derive(Debug)]
pub(crate) enum Interruption {
    /// The evaluator: all steps that jobs took are whole, and can be kept.
    Evaluation(Error),
    /// Anything else: only what was recorded before is sure.
    Other(Failure),
}

impl From<Error> for Interruption {
    fn from(error: Error) -> Self {
        Self::Evaluation(error)
    }
}

impl From<Failure> for Interruption {
    fn from(failure: Failure) -> Self {
        Self::Other(failure)
    }
}

impl From<Invalid> for Interruption {
    fn from(invalid: Invalid) -> Self {
        Self::Other(invalid.into())
    }
}

/// Batches on their way to the device and back, so that jobs advance while it evaluates.
pub(super) struct Queue<'a> {
    pub(super) batches: Sender<Batch>,
    pub(super) outcomes: Receiver<Result<Outcome, Error>>,
    /// Counts the robot-steps, and cancels them.
    pub(super) control: &'a Control,
    pub(super) stop: &'a AtomicBool,
}

impl Queue<'_> {
    /// Hands a batch over; outcomes come in the same order.
    pub(super) fn submit(&self, batch: Batch) {
        // A thread that has ended is noticed where its outcome is awaited.
        let _ = self.batches.send(batch);
    }

    /// Waits for the next outcome.
    pub(super) fn receive(&self, watch: &mut dyn Watch) -> Result<Outcome, Interruption> {
        const BLINK: Duration = Duration::from_millis(100);
        loop {
            if watch.stops() || self.stop.load(Ordering::Relaxed) {
                self.control.cancel();
                return Err(Error::Cancelled.into());
            }
            let outcome = self.outcomes.recv_timeout(BLINK);
            watch.steps(self.control.steps());
            match outcome {
                Ok(outcome) => return Ok(outcome?),
                Err(RecvTimeoutError::Timeout) => (),
                Err(RecvTimeoutError::Disconnected) => return Err(Failure::failed("the evaluator broke down").into()),
            }
        }
    }
}
