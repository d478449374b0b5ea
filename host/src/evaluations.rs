//! An evaluator that all of a study shares: its simulations, its realities, its swarms.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use oneiro::batch::{Batch, Outcome};
use oneiro::evaluator::{Control, Error, Evaluator};

use crate::reality::Trouble;

/// An evaluator that simulations and realities of one study share, and what stops it.
pub(crate) struct Evaluations {
    evaluator: RefCell<Box<dyn Evaluator>>,
    /// Counts the steps.
    pub(crate) control: Control,
    stop: Arc<AtomicBool>,
}

impl Evaluations {
    /// Of an evaluator, until `stop` is set.
    pub(crate) fn new(evaluator: Box<dyn Evaluator>, stop: Arc<AtomicBool>) -> Self {
        Self {
            evaluator: RefCell::new(evaluator),
            control: Control::new(),
            stop,
        }
    }

    /// Runs a batch.
    pub(crate) fn evaluate(&self, batch: &Batch) -> Result<Outcome, Error> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(Error::Cancelled);
        }
        self.evaluator.borrow_mut().evaluate(batch, &self.control)
    }

    /// Runs a batch for a reality.
    pub(crate) fn run(&self, batch: &Batch) -> Result<Outcome, Trouble> {
        match self.evaluate(batch) {
            Ok(outcome) => Ok(outcome),
            Err(Error::Cancelled) => Err(Trouble::Stopped),
            Err(error) => Err(Trouble::Broken(error.to_string())),
        }
    }

    /// The evaluator, when all is done.
    pub(crate) fn close(self) -> Box<dyn Evaluator> {
        self.evaluator.into_inner()
    }
}
