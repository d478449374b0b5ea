//! A device that answers at once, to measure the host without one.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use oneiro::batch::{Batch, LANES, Outcome, Part, PartResult};
use oneiro::evaluator::{Control, Device, Error, Evaluator};
use oneiro_lab::device::NULL;

/// Simulates nothing: a rollout's fitness is the sum of its genes, so that selection has something to sort.
#[derive(Debug, Default)]
pub(super) struct Null {
    /// Nanoseconds in which results were put into the order of rollouts.
    placing: Arc<AtomicU64>,
}

impl Null {
    /// A function that returns the time in which results were put into the order of rollouts.
    pub(super) fn placing(&self) -> impl Fn() -> Duration + use<> {
        let placing = Arc::clone(&self.placing);
        move || Duration::from_nanos(placing.load(Ordering::Relaxed))
    }
}

impl Evaluator for Null {
    fn device(&self) -> Device {
        Device {
            name: NULL.into(),
            detail: "simulates nothing".into(),
            exact: true,
        }
    }

    fn evaluate_part(&mut self, part: &Part<'_>, control: &Control) -> Result<PartResult, Error> {
        /// Words of a key, which precede the genes.
        const KEY: usize = 2;
        if control.is_cancelled() {
            return Err(Error::Cancelled);
        }
        let mut fitness = vec![0.0; part.slots()];
        let groups = part.group_table();
        for (index, fitness) in fitness.chunks_exact_mut(LANES).enumerate() {
            let begins = |index: usize| Some((groups.get(index)?.inputs - part.first_input()) as usize);
            let end = begins(index + 1).unwrap_or(part.inputs().len());
            let inputs = &part.inputs()[begins(index).unwrap_or(end)..end];
            for gene in inputs.chunks_exact(LANES).skip(KEY) {
                for (sum, &bits) in fitness.iter_mut().zip(gene) {
                    *sum += f32::from_bits(bits);
                }
            }
        }
        control.add_steps(part.steps());
        let batch = part.batch();
        Ok(PartResult {
            fitness,
            trace: vec![0; part.slots() * batch.trace_words()],
            states: vec![0; part.slots() * batch.kept_words()],
        })
    }

    fn evaluate(&mut self, batch: &Batch, control: &Control) -> Result<Outcome, Error> {
        let result = self.evaluate_part(&batch.all(), control)?;
        let began = Instant::now();
        let outcome = batch.outcome(result);
        self.placing
            .fetch_add(began.elapsed().as_nanos() as u64, Ordering::Relaxed);
        Ok(outcome)
    }
}
