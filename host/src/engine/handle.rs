//! The engine's handle: an evaluator for all jobs and all single evaluations of a command.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use oneiro::batch::{Batch, Outcome};
use oneiro::evaluator::{Control, Device, Error, Evaluator};

use super::job::Job;
use super::queue::Queue;
use super::scheduler::{self, InMemory, Runs, Waiting};
use super::watcher::Watch;

/// The one way to hold an evaluator: all jobs and all single evaluations of a command share it, and what stops them.
pub(crate) struct Engine {
    evaluator: Mutex<Box<dyn Evaluator>>,
    description: Device,
    /// Counts the robot-steps.
    pub(crate) control: Control,
    stop: Arc<AtomicBool>,
}

impl Engine {
    /// Of an evaluator; it works until `stop` is set.
    pub(crate) fn new(evaluator: Box<dyn Evaluator>, stop: Arc<AtomicBool>) -> Self {
        Self {
            description: evaluator.device(),
            evaluator: Mutex::new(evaluator),
            control: Control::new(),
            stop,
        }
    }

    /// What the evaluator runs on.
    pub(crate) fn description(&self) -> &Device {
        &self.description
    }

    /// The device in a few words.
    pub(crate) fn name(&self) -> String {
        let Device { name, detail, exact } = &self.description;
        let exact = if *exact { "" } else { ", not exact" };
        format!("{name} ({detail}{exact})")
    }

    /// Does runs, as far as batches allow in the order given; `most` limits how many are under way at once.
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
        let (batches, submitted) = mpsc::channel::<Batch>();
        let (results, outcomes) = mpsc::channel();
        let queue = Queue {
            batches,
            outcomes,
            control: &self.control,
            stop: &self.stop,
        };
        thread::scope(|scope| {
            let worker = scope.spawn(move || {
                for batch in submitted {
                    if results.send(self.evaluate(&batch)).is_err() {
                        break;
                    }
                }
            });
            let ended = scheduler::run(waiting, most, runs, &queue, watch);
            if ended.is_err() {
                // Nobody waits for what it still has to do.
                self.control.cancel();
            }
            drop(queue);
            // A worker that broke down was noticed where its outcome was awaited.
            let _ = worker.join();
            ended
        })
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

    /// Evaluates one batch, on this thread.
    ///
    /// # Errors
    /// As [`Evaluator::evaluate`].
    pub(crate) fn evaluate(&self, batch: &Batch) -> Result<Outcome, Error> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(Error::Cancelled);
        }
        let mut evaluator = self.evaluator.lock().unwrap_or_else(PoisonError::into_inner);
        evaluator.evaluate(batch, &self.control)
    }

    /// The evaluator's warnings, when all is done.
    pub(crate) fn close(self) -> Vec<String> {
        let evaluator = self.evaluator.into_inner().unwrap_or_else(PoisonError::into_inner);
        evaluator.warnings().to_vec()
    }
}
