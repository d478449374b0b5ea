//! Batches on their way to the device and back, and reasons for ending early.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::Duration;

use oneiro::batch::{Batch, Outcome};
use oneiro::evaluator::{Control, Error};
use oneiro::parameter::Invalid;

use super::watcher::Watch;
use crate::exit::Failure;

/// Reasons for work on a device to end early.
#[derive(Debug)]
pub(crate) enum Interruption {
    /// The evaluator: all finished steps of jobs are complete and can be saved.
    Evaluation(Error),
    /// Anything else: only earlier records are safe.
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
    /// Counts robot-steps and cancels work.
    pub(super) control: &'a Control,
    pub(super) stop: &'a AtomicBool,
}

impl Queue<'_> {
    /// Hands a batch over; outcomes come back in the same order.
    pub(super) fn submit(&self, batch: Batch) {
        // If the thread has ended, that is noticed when its outcome is awaited.
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
                Err(RecvTimeoutError::Disconnected) => return Err(Failure::failed("the evaluator crashed").into()),
            }
        }
    }
}
