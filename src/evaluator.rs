//! The one trait between what is evaluated and where.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::batch::{Batch, Outcome, Part};

/// How a run of an evaluator is watched and stopped from outside, from any thread.
#[derive(Debug, Default)]
pub struct Control {
    cancelled: AtomicBool,
    steps: AtomicU64,
}

impl Control {
    /// Nothing cancelled, no step done.
    pub fn new() -> Self {
        Self::default()
    }
    /// Asks the evaluation to stop soon; it then returns [`Error::Cancelled`].
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }
    /// Whether [`Control::cancel`] was called.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
    /// Robot-steps done so far.
    pub fn steps(&self) -> u64 {
        self.steps.load(Ordering::Relaxed)
    }
    /// Called by evaluators as they go.
    pub fn add_steps(&self, steps: u64) {
        self.steps.fetch_add(steps, Ordering::Relaxed);
    }
    /// Called by evaluators whose steps came to nothing and are done again, as after a lost device.
    pub fn take_back_steps(&self, steps: u64) {
        self.steps.fetch_sub(steps, Ordering::Relaxed);
    }
}

/// Why an evaluation gave no result. Never the batch's content: that was checked when it was made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// [`Control::cancel`] was called.
    #[error("the evaluation was cancelled")]
    Cancelled,
    /// There is no such device here, or it can't run the kernels.
    #[error("{0}")]
    NoDevice(String),
    /// The device was lost, and so was its replacement.
    #[error("the device {device} was lost: {reason}")]
    Lost {
        /// Its name.
        device: String,
        /// What the driver said.
        reason: String,
    },
    /// A trace or a batch that no device here has the memory for.
    #[error("{0}")]
    TooLarge(String),
    /// An audited rollout had other bits on the CPU.
    #[error(
        "rollout {rollout}: {device} computed {there} (bits {:08x}), the CPU {here} (bits {:08x}); \
         results of this device can't be trusted to be exact",
        there.to_bits(), here.to_bits()
    )]
    Differs {
        /// Its index in the batch.
        rollout: usize,
        /// The device's name.
        device: String,
        /// The device's fitness.
        there: f32,
        /// The CPU's fitness.
        here: f32,
    },
}

/// What an evaluator runs on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Device {
    /// `cpu` or the adapter's name.
    pub name: String,
    /// Instruction set and lanes, or the driver's name and version.
    pub detail: String,
    /// Whether results are promised to be the same bits as everywhere.
    pub exact: bool,
}

/// What runs batches. Results depend on the batch alone: never on the evaluator, its threads, or how it cuts.
pub trait Evaluator: Send {
    /// What it runs on.
    fn device(&self) -> Device;

    /// Runs a part of a batch and returns the fitness of each of its slots, and its trace.
    ///
    /// # Errors
    /// See [`Error`]; none is about the batch's content.
    fn evaluate_part(&mut self, part: &Part<'_>, control: &Control) -> Result<PartResult, Error>;

    /// Runs a batch: the fitness of each rollout in the order in which they were given, and on request traces.
    ///
    /// # Errors
    /// As [`Evaluator::evaluate_part`].
    fn evaluate(&mut self, batch: &Batch, control: &Control) -> Result<Outcome, Error> {
        let result = self.evaluate_part(&batch.all(), control)?;
        Ok(batch.outcome(result))
    }

    /// What the user should know although the results are right, such as a device that was lost; oldest first.
    fn warnings(&self) -> &[String] {
        &[]
    }
}

/// What a part's evaluation gives: one fitness a slot (idle slots hold anything), and on request traces and states, as
/// words that [`Batch::place`] finds.
#[derive(Clone, Debug, Default)]
pub struct PartResult {
    /// `part.slots()` values.
    pub fitness: Vec<f32>,
    /// `part.slots() * batch.trace_words()` words, or none.
    pub trace: Vec<u32>,
    /// `part.slots() * batch.state_words()` words, or none.
    pub states: Vec<u32>,
}

impl PartResult {
    /// Room for a part's results.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if there is no memory for it.
    pub(crate) fn blank(batch: &Batch, slots: usize) -> Result<Self, Error> {
        Ok(Self {
            fitness: room(slots)?,
            trace: room(slots * batch.trace_words())?,
            states: room(slots * batch.kept_words())?,
        })
    }
}

/// So many zeros, if there is memory for them.
fn room<T: Clone + Default>(len: usize) -> Result<Vec<T>, Error> {
    let mut values = Vec::new();
    values.try_reserve_exact(len).map_err(|_| {
        Error::TooLarge(format!(
            "results of {} MB do not fit into memory: evaluate fewer rollouts, or trace fewer of them or less often",
            (len * size_of::<T>()) >> 20
        ))
    })?;
    values.resize(len, T::default());
    Ok(values)
}
