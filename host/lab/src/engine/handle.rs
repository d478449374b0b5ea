//! The engine's handle: an evaluator that all jobs and all single evaluations of a command share.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use oneiro::batch::{Batch, Outcome};
use oneiro::evaluator::{Control, Device, Error, Evaluator};

use super::job::Job;
use super::queue::{Interruption, Queue, Work};
use super::scheduler::{self, InMemory, Runs, Waiting};
use super::watcher::Watch;

/// An engine's report when it is closed.
pub struct Closed {
    /// Warnings of its evaluator.
    pub warnings: Vec<String>,
    /// Fraction of all robot-steps that kernels specialised to their worlds have simulated; 0 on CPUs.
    pub specialised: f64,
}

/// The only holder of an evaluator: all jobs and all single evaluations of a command share it, and its stop flag.
pub struct Engine {
    evaluator: Mutex<Box<dyn Evaluator>>,
    description: Device,
    /// Counter of robot-steps.
    pub control: Control,
    stop: Arc<AtomicBool>,
}

impl Engine {
    /// Wraps an evaluator, which works until `stop` is set.
    pub fn new(evaluator: Box<dyn Evaluator>, stop: Arc<AtomicBool>) -> Self {
        Self {
            description: evaluator.device(),
            evaluator: Mutex::new(evaluator),
            control: Control::new(),
            stop,
        }
    }

    /// Description of the evaluator's device.
    pub fn description(&self) -> &Device {
        &self.description
    }

    /// Short name of the device.
    pub fn name(&self) -> String {
        let Device { name, detail, exact } = &self.description;
        let exact = if *exact { "" } else { ", not exact" };
        format!("{name} ({detail}{exact})")
    }

    /// Executes runs, in the given order as far as batches allow; `most` limits the number in progress at once.
    ///
    /// # Errors
    /// Exit 75 if the work was stopped, and errors of the evaluator, in both cases with all jobs in progress saved;
    /// errors of [`Runs`] and of jobs.
    pub fn run(
        &self,
        waiting: Vec<Waiting>,
        most: usize,
        runs: &mut impl Runs,
        watch: &mut dyn Watch,
    ) -> oneiro_base::exit::Result {
        let (work, submitted) = mpsc::channel::<Work>();
        let (results, outcomes) = mpsc::channel();
        let queue = Queue::new(work, outcomes, self);
        thread::scope(|scope| {
            let worker = scope.spawn(move || {
                for work in submitted {
                    if results.send(self.done(&work)).is_err() {
                        break;
                    }
                }
            });
            let ended = scheduler::run(waiting, most, runs, queue, watch);
            if ended.is_err() {
                // The results of the remaining work aren't needed.
                self.control.cancel();
            }
            // If the worker panicked, that was noticed when its outcome was awaited.
            let _ = worker.join();
            ended
        })
    }

    /// Runs jobs to their end and keeps only the jobs.
    ///
    /// # Errors
    /// As [`Engine::run`].
    pub fn finished<J: Job>(&self, jobs: Vec<J>, watch: &mut dyn Watch) -> oneiro_base::exit::Result<Vec<J>> {
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

    /// Set once the user stops the work.
    pub fn stop(&self) -> &Arc<AtomicBool> {
        &self.stop
    }

    /// Does some work on this thread.
    pub(super) fn done(&self, work: &Work) -> Result<Outcome, Interruption> {
        match work {
            Work::Batch(batch) => Ok(self.evaluate(batch)?),
            Work::Outside(lives) => {
                let mut outcome = Outcome::default();
                for lives in lives {
                    outcome.fitness.extend(lives.live(&self.stop)?);
                }
                Ok(outcome)
            }
        }
    }

    /// Evaluates one batch on this thread.
    ///
    /// # Errors
    /// As [`Evaluator::evaluate`].
    pub fn evaluate(&self, batch: &Batch) -> Result<Outcome, Error> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(Error::Cancelled);
        }
        let mut evaluator = self.evaluator.lock().unwrap_or_else(PoisonError::into_inner);
        evaluator.evaluate(batch, &self.control)
    }

    /// Ends after all work.
    pub fn close(self) -> Closed {
        let evaluator = self.evaluator.into_inner().unwrap_or_else(PoisonError::into_inner);
        Closed {
            warnings: evaluator.warnings().to_vec(),
            specialised: match self.control.steps() {
                0 => 0.0,
                steps => evaluator.specialised_steps() as f64 / steps as f64,
            },
        }
    }
}
