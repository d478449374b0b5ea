//! The engine's handle: an evaluator on a thread of its own, so that jobs advance while it evaluates.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use oneiro::batch::{Batch, Outcome};
use oneiro::evaluator::{self, Control, Error, Evaluator};
use oneiro::world::Invalid;

use super::job::Job;
use super::scheduler::{self, InMemory, Runs, Waiting};
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

/// An evaluator on a thread of its own.
struct Thread {
    batches: Sender<Batch>,
    outcomes: Receiver<Result<Outcome, Error>>,
    handle: JoinHandle<Box<dyn Evaluator>>,
}

/// The one way to hold an evaluator: all jobs and all single evaluations of a command share it, and what stops them.
pub(crate) struct Engine {
    thread: Thread,
    description: evaluator::Device,
    /// Counts the robot-steps.
    pub(crate) control: Arc<Control>,
    stop: Arc<AtomicBool>,
}

impl Engine {
    /// Gives an evaluator its thread; it works until `stop` is set.
    pub(crate) fn new(mut evaluator: Box<dyn Evaluator>, stop: Arc<AtomicBool>) -> Self {
        let description = evaluator.device();
        let (batches, submitted) = mpsc::channel::<Batch>();
        let (results, outcomes) = mpsc::channel();
        let control = Arc::new(Control::new());
        let own = Arc::clone(&control);
        let handle = thread::spawn(move || {
            for batch in submitted {
                if results.send(evaluator.evaluate(&batch, &own)).is_err() {
                    break;
                }
            }
            evaluator
        });
        Self {
            thread: Thread {
                batches,
                outcomes,
                handle,
            },
            description,
            control,
            stop,
        }
    }

    /// What the evaluator runs on.
    pub(crate) fn description(&self) -> &evaluator::Device {
        &self.description
    }

    /// The device in a few words.
    pub(crate) fn name(&self) -> String {
        let evaluator::Device { name, detail, exact } = &self.description;
        let exact = if *exact { "" } else { ", not exact" };
        format!("{name} ({detail}{exact})")
    }

    /// Does runs, in their order as far as batches allow it; at most so many at a time.
    ///
    /// # Errors
    /// Exit 75 when the work was stopped, and as the evaluator's errors, both with all jobs under way saved; the errors of
    /// [`Runs`] and of jobs.
    pub(crate) fn run(
        &self,
        waiting: Vec<Waiting>,
        most: usize,
        runs: &mut impl Runs,
        watch: &mut dyn Watch,
    ) -> crate::exit::Result {
        scheduler::run(waiting, most, runs, self, watch)
    }

    /// Runs jobs to their end, and keeps nothing but them.
    ///
    /// # Errors
    /// As [`Engine::run`].
    pub(crate) fn finished<J: Job>(&self, jobs: Vec<J>, watch: &mut dyn Watch) -> crate::exit::Result<Vec<J>> {
        let kernel = |job: &J| job.ask().map_or("", |request| request.stage.kernel);
        let waiting = jobs.iter().enumerate().map(|(run, job)| Waiting {
            run,
            kernel: kernel(job),
        });
        let (waiting, most) = (waiting.collect(), jobs.len());
        let mut runs = InMemory(jobs.into_iter().map(Some).collect());
        self.run(waiting, most, &mut runs, watch)?;
        Ok(runs.0.into_iter().flatten().collect())
    }

    /// Evaluates one batch.
    ///
    /// # Errors
    /// As [`Evaluator::evaluate`].
    pub(crate) fn evaluate(&self, batch: Batch) -> Result<Outcome, Error> {
        self.submit(batch);
        self.receive(&mut ()).map_err(|interruption| match interruption {
            Interruption::Evaluation(error) => error,
            Interruption::Other(failure) => Error::NoDevice(failure.to_string()),
        })
    }

    /// Hands a batch over; outcomes come in the same order.
    pub(super) fn submit(&self, batch: Batch) {
        // A thread that has ended is noticed where its outcome is awaited.
        let _ = self.thread.batches.send(batch);
    }

    /// Waits for the next outcome.
    pub(super) fn receive(&self, watch: &mut dyn Watch) -> Result<Outcome, Interruption> {
        const BLINK: Duration = Duration::from_millis(100);
        loop {
            if watch.stops() || self.stop.load(Ordering::Relaxed) {
                self.control.cancel();
                return Err(Error::Cancelled.into());
            }
            let outcome = self.thread.outcomes.recv_timeout(BLINK);
            watch.steps(self.control.steps());
            match outcome {
                Ok(outcome) => return Ok(outcome?),
                Err(RecvTimeoutError::Timeout) => (),
                Err(RecvTimeoutError::Disconnected) => return Err(Failure::failed("the evaluator broke down").into()),
            }
        }
    }

    /// Ends the thread. The evaluator's warnings.
    pub(crate) fn close(self) -> Vec<String> {
        drop(self.thread.batches);
        let evaluator = self.thread.handle.join();
        evaluator.map_or_else(|_| Vec::new(), |evaluator| evaluator.warnings().to_vec())
    }
}
