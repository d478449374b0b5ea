//! The trait that every device implements: a batch in, results out.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use oneiro_shaders::Kernel;

use crate::batch::{Batch, LANES, Observer, Outcome, Part, PartResult};

/// Watches and cancels an evaluation, from any thread.
#[derive(Debug, Default)]
pub struct Control {
    cancelled: AtomicBool,
    steps: AtomicU64,
}

impl Control {
    /// A control that isn't cancelled and has counted no steps.
    pub fn new() -> Self {
        Self::default()
    }
    /// Cancels the evaluation, which soon returns [`Error::Cancelled`].
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
    /// Adds finished steps; called by evaluators.
    pub fn add_steps(&self, steps: u64) {
        self.steps.fetch_add(steps, Ordering::Relaxed);
    }
    /// Subtracts steps that must be repeated, as after a lost device; called by evaluators.
    pub fn take_back_steps(&self, steps: u64) {
        self.steps.fetch_sub(steps, Ordering::Relaxed);
    }
}

/// Reason why an evaluation gave no result. It is never the batch's content, which was checked when the batch was made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// [`Control::cancel`] was called.
    #[error("the evaluation was cancelled")]
    Cancelled,
    /// This machine has no such device, or the device can't run the kernels.
    #[error("{0}")]
    NoDevice(String),
    /// There is not enough memory, or no thread can be started.
    #[error("{0}")]
    Short(String),
    /// The device was lost, and so was its replacement.
    #[error("the device {device} was lost: {reason}")]
    Lost {
        /// Name of the device.
        device: String,
        /// The driver's message.
        reason: String,
    },
    /// A trace or a batch needs more memory than the device has.
    #[error("{0}")]
    TooLarge(String),
    /// A kernel's loops turned more often than its text allows, so the machine code made of it at run time is wrong.
    #[error(
        "the kernel {kernel} looped {turns} times, more than its source allows: its machine code is wrong. This is a \
         mistake in Oneiro; please report it with the experiment"
    )]
    Unbounded {
        /// Name of the kernel.
        kernel: String,
        /// Turns that its text allows.
        turns: u64,
    },
    /// An operation on numbers has a result that devices may compute in different ways, of a [`Cpu`](crate::cpu::Cpu) that
    /// [checks operations](crate::cpu::Cpu::checking).
    #[error("{place}: {what}")]
    Inexact {
        /// File, line and column.
        place: String,
        /// The operation and its result.
        what: String,
    },
    /// An audited episode has different bits on the CPU.
    #[error(
        "episode {rollout}: {device} computed {there} (bits {:08x}), the CPU {here} (bits {:08x}); results of this \
         device can't be trusted to be exact",
        there.to_bits(), here.to_bits()
    )]
    Differs {
        /// Index in the batch.
        rollout: usize,
        /// Name of the device.
        device: String,
        /// Fitness on the device.
        there: f32,
        /// Fitness on the CPU.
        here: f32,
    },
}

/// The device of an evaluator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Device {
    /// `cpu` or the adapter's name, or several joined.
    pub name: String,
    /// Instruction set and lanes, or the driver's name and version.
    pub detail: String,
    /// Whether results are guaranteed to equal those of every other exact device, bit for bit.
    pub exact: bool,
}

/// Runs batches. Results depend only on the batch, never on the device, its threads, or how it divides the batch.
pub trait Evaluator: Send {
    /// The device that it runs on.
    fn device(&self) -> Device;

    /// The same, with the details of how it runs a kernel.
    fn device_for(&self, _kernel: &'static Kernel) -> Device {
        self.device()
    }

    /// Runs a part of a batch and returns the fitness of each of its slots, and traces and states if requested.
    ///
    /// # Errors
    /// See [`Error`]; none is about the batch's content.
    fn evaluate_part(&mut self, part: &Part<'_>, control: &Control) -> Result<PartResult, Error>;

    /// Runs a batch and returns the fitness of each episode, in the given order, and traces and states if requested.
    ///
    /// # Errors
    /// As [`Evaluator::evaluate_part`].
    fn evaluate(&mut self, batch: &Batch, control: &Control) -> Result<Outcome, Error> {
        let result = self.evaluate_part(&batch.all(), control)?;
        Ok(batch.outcome(result))
    }

    /// As [`Evaluator::evaluate`], for an observer of traces: the result has none. The CPU shows lines while it simulates, so that
    /// whole traces are never in memory.
    ///
    /// # Errors
    /// As [`Evaluator::evaluate_part`].
    fn observe(&mut self, batch: &Batch, control: &Control, observer: Observer<'_>) -> Result<Outcome, Error> {
        let result = self.evaluate_part(&batch.all(), control)?;
        Ok(batch.observed(result, observer))
    }

    /// Warnings for the user, such as a lost device, oldest first. Results are right nevertheless.
    fn warnings(&self) -> &[String] {
        &[]
    }

    /// Robot-steps that kernels specialised to their worlds have simulated so far.
    fn specialised_steps(&self) -> u64 {
        0
    }
}

/// Appends an evaluator's new warnings, those after the first `heard`, to `warnings`.
pub(crate) fn pass_on(evaluator: &dyn Evaluator, heard: &mut usize, warnings: &mut Vec<String>) {
    let all = evaluator.warnings();
    warnings.extend(all.iter().skip(*heard).cloned());
    *heard = all.len();
}

impl PartResult {
    /// Allocates the results of a part.
    ///
    /// # Errors
    /// [`Error::Short`] if there isn't enough memory.
    pub(crate) fn blank(batch: &Batch, slots: usize) -> Result<Self, Error> {
        Ok(Self {
            trace: room(slots * batch.trace_words())?,
            ..Self::untraced(batch, slots)?
        })
    }

    /// The same without traces.
    pub(crate) fn untraced(batch: &Batch, slots: usize) -> Result<Self, Error> {
        Ok(Self {
            fitness: room(slots)?,
            trace: Vec::new(),
            states: room(slots * batch.kept_words())?,
        })
    }

    /// Puts the results of some of a part's groups in their places.
    pub(crate) fn put(&mut self, batch: &Batch, groups: &Range<u32>, result: &Self) {
        let first = groups.start as usize * LANES;
        self.fitness[first..][..result.fitness.len()].copy_from_slice(&result.fitness);
        self.trace[first * batch.trace_words()..][..result.trace.len()].copy_from_slice(&result.trace);
        self.states[first * batch.kept_words()..][..result.states.len()].copy_from_slice(&result.states);
    }
}

/// Allocates a vector of default values, if there is enough memory.
fn room<T: Clone + Default>(len: usize) -> Result<Vec<T>, Error> {
    let mut values = Vec::new();
    values.try_reserve_exact(len).map_err(|_| {
        Error::Short(format!(
            "results of {} kB don't fit into memory; allowed: fewer episodes, fewer or shorter traces, or more memory",
            (len * size_of::<T>()) >> 10
        ))
    })?;
    values.resize(len, T::default());
    Ok(values)
}
