//! Work on its way to the device and back, and reasons for ending early.

use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::Duration;

use oneiro::batch::{Batch, Outcome, Rollout};
use oneiro::evaluator::Error;
use oneiro::parameter::Invalid;
use oneiro::random::Key;
use oneiro_base::exit::Failure;

use super::handle::Engine;
use super::job::Outside;
use super::watcher::Watch;

/// Reasons for work on a device to end early.
#[derive(Debug)]
pub enum Interruption {
    /// The evaluator: all finished steps of jobs are complete and can be saved.
    Evaluation(Error),
    /// A place outside of the device: likewise.
    Outside(Failure),
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

/// Work that is evaluated at once.
pub(super) enum Work {
    /// By the device.
    Batch(Batch),
    /// In other places, one after the other.
    Outside(Vec<Lives>),
}

/// Episodes that run outside of the device.
pub(super) struct Lives {
    outside: Arc<dyn Outside>,
    /// Genes and key of each.
    rollouts: Vec<(Vec<f32>, Key)>,
}

impl Lives {
    pub(super) fn new(outside: &Arc<dyn Outside>, rollouts: &[Rollout<'_>]) -> Self {
        let own = rollouts.iter().map(|rollout| (rollout.genes.to_vec(), rollout.key));
        Self {
            outside: Arc::clone(outside),
            rollouts: own.collect(),
        }
    }

    /// Number of episodes.
    pub(super) fn len(&self) -> usize {
        self.rollouts.len()
    }

    /// Runs them, and returns the fitness of each.
    pub(super) fn live(&self, stop: &Arc<AtomicBool>) -> Result<Vec<f32>, Interruption> {
        let rollouts: Vec<_> = self
            .rollouts
            .iter()
            .map(|(genes, key)| Rollout {
                world: 0,
                genes,
                key: *key,
            })
            .collect();
        self.outside.live(&rollouts, stop)
    }
}

/// Work on its way to the device or another place and back, so that jobs advance meanwhile.
pub(super) struct Queue<'a> {
    work: Sender<Work>,
    outcomes: Receiver<Result<Outcome, Interruption>>,
    engine: &'a Engine,
    /// Batches that were submitted and whose outcomes have not been received.
    waiting: usize,
    /// A short batch with nothing in flight: evaluated on this thread, since waking another would take a good part of its time.
    held: Option<Work>,
}

impl<'a> Queue<'a> {
    pub(super) fn new(
        work: Sender<Work>,
        outcomes: Receiver<Result<Outcome, Interruption>>,
        engine: &'a Engine,
    ) -> Self {
        Self {
            work,
            outcomes,
            engine,
            waiting: 0,
            held: None,
        }
    }

    /// Hands work over; outcomes come back in the same order.
    pub(super) fn submit(&mut self, work: Work, is_short: bool) {
        let is_alone = self.waiting == 0 && self.held.is_none();
        if is_short && is_alone && matches!(work, Work::Batch(_)) {
            self.held = Some(work);
            return;
        }
        for work in self.held.take().into_iter().chain([work]) {
            self.waiting += 1;
            // If the thread has ended, that is noticed when its outcome is awaited.
            let _ = self.work.send(work);
        }
    }

    /// Waits for the next outcome.
    pub(super) fn receive(&mut self, watch: &mut dyn Watch) -> Result<Outcome, Interruption> {
        const BLINK: Duration = Duration::from_millis(100);
        let control = &self.engine.control;
        loop {
            if watch.stops() || self.engine.stop().load(Ordering::Relaxed) {
                control.cancel();
                return Err(Error::Cancelled.into());
            }
            let outcome = match self.held.take() {
                Some(work) => {
                    self.waiting += 1;
                    // Reported like a panic of the other thread. The engine is not used again after one.
                    panic::catch_unwind(AssertUnwindSafe(|| self.engine.done(&work)))
                        .map_err(|_| RecvTimeoutError::Disconnected)
                }
                None => self.outcomes.recv_timeout(BLINK),
            };
            watch.steps(control.steps());
            match outcome {
                Ok(outcome) => {
                    self.waiting -= 1;
                    return outcome;
                }
                Err(RecvTimeoutError::Timeout) => (),
                Err(RecvTimeoutError::Disconnected) => return Err(Failure::broken("the evaluator").into()),
            }
        }
    }
}
