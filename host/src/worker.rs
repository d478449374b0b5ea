//! An evaluator on a thread of its own, so that this one evolves while it evaluates.

use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use oneiro::batch::{Batch, Outcome};
use oneiro::evaluator::{Control, Error, Evaluator};

use crate::exit::Failure;
use crate::run::Interruption;

/// What watches evaluations as they go.
pub(crate) trait Watch {
    /// Whether to stop.
    fn stops(&self) -> bool;
    /// Called every now and then with the robot-steps that have been done.
    fn steps(&mut self, done: u64);
}

/// An evaluator on a thread of its own.
pub(crate) struct Worker {
    jobs: Sender<Batch>,
    outcomes: Receiver<Result<Outcome, Error>>,
    control: Arc<Control>,
    thread: JoinHandle<Box<dyn Evaluator>>,
}

impl Worker {
    /// Gives an evaluator its thread.
    pub(crate) fn new(mut evaluator: Box<dyn Evaluator>) -> Self {
        let (jobs, batches) = mpsc::channel::<Batch>();
        let (results, outcomes) = mpsc::channel();
        let control = Arc::new(Control::new());
        let own = Arc::clone(&control);
        let thread = thread::spawn(move || {
            for batch in batches {
                if results.send(evaluator.evaluate(&batch, &own)).is_err() {
                    break;
                }
            }
            evaluator
        });
        Self {
            jobs,
            outcomes,
            control,
            thread,
        }
    }

    /// Hands a batch over; outcomes come in the same order.
    pub(crate) fn submit(&self, batch: Batch) {
        // A thread that has ended is noticed where its outcome is awaited.
        let _ = self.jobs.send(batch);
    }

    /// Waits for the next outcome.
    pub(crate) fn receive(&self, watch: &mut dyn Watch) -> Result<Outcome, Interruption> {
        const BLINK: Duration = Duration::from_millis(100);
        loop {
            if watch.stops() {
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

    /// Ends the thread. What the evaluator has to tell the user.
    pub(crate) fn close(self) -> Vec<String> {
        drop(self.jobs);
        self.thread
            .join()
            .map_or_else(|_| Vec::new(), |evaluator| evaluator.warnings().to_vec())
    }
}
