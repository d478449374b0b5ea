//! Audits: a fraction of a device's results is computed again on the CPU and compared bit for bit.

use std::panic::resume_unwind;
use std::thread;

use crate::batch::{Batch, LANES, Part, PartResult};
use crate::devices::cpu::Cpu;
use crate::evaluator::{Control, Device, Error, Evaluator};
use crate::random::pcg4d;

/// An evaluator with audits: in each call the CPU also runs a fraction of the groups of 64 episodes, at the same time. Only the
/// episodes' keys decide which.
pub struct Audited {
    evaluator: Box<dyn Evaluator>,
    cpu: Cpu,
    share: f64,
}

impl Audited {
    /// Audits a fraction of an evaluator's groups, from 0 (none) to 1 (all). Above 0, at least one group per call.
    pub fn new(evaluator: Box<dyn Evaluator>, cpu: Cpu, share: f64) -> Self {
        Self { evaluator, cpu, share }
    }

    /// Groups of a part to run again.
    fn chosen(&self, part: &Part<'_>) -> Vec<u32> {
        let lots: Vec<(u32, u32)> = part.groups().map(|group| (lot(part.batch(), group), group)).collect();
        let drawn = lots
            .iter()
            .filter(|(lot, _)| f64::from(*lot) < self.share * 2.0_f64.powi(32));
        let mut chosen: Vec<u32> = drawn.map(|(_, group)| *group).collect();
        if chosen.is_empty() && self.share > 0.0 {
            chosen.extend(lots.iter().min().map(|(_, group)| *group));
        }
        chosen
    }
}

impl Evaluator for Audited {
    fn device(&self) -> Device {
        self.evaluator.device()
    }

    fn evaluate_part(&mut self, part: &Part<'_>, control: &Control) -> Result<PartResult, Error> {
        let chosen = self.chosen(part);
        let batch = part.batch();
        let Self { evaluator, cpu, .. } = self;
        let (here, there) = thread::scope(|scope| {
            let here = scope.spawn(|| cpu.run(batch, &chosen, control, false, None));
            let there = evaluator.evaluate_part(part, control);
            (here.join().unwrap_or_else(|panic| resume_unwind(panic)), there)
        });
        let (there, here) = (there?, here?);
        let in_trace = batch.places("trace", batch.trace_words());
        let in_state = batch.places("state", batch.state_words());
        for (index, group) in chosen.into_iter().enumerate() {
            for lane in 0..batch.part(group..group + 1).rollouts() {
                let slot = (group - part.groups().start) as usize * LANES + lane;
                let slot_here = index * LANES + lane;
                let fitness = (there.fitness[slot].to_bits(), here.fitness[slot_here].to_bits());
                let trace = (0..batch.trace_words())
                    .map(|word| (there.trace[in_trace(slot, word)], here.trace[in_trace(slot_here, word)]));
                let states = (0..batch.kept_words()).map(|word| {
                    (
                        there.states[in_state(slot, word)],
                        here.states[in_state(slot_here, word)],
                    )
                });
                let differing = std::iter::once(fitness)
                    .chain(trace)
                    .chain(states)
                    .find(|(there, here)| there != here);
                if let Some((there, here)) = differing {
                    return Err(Error::Differs {
                        rollout: batch.rollout(group as usize * LANES + lane).unwrap_or_default(),
                        device: self.device().name,
                        there: f32::from_bits(there),
                        here: f32::from_bits(here),
                    });
                }
            }
        }
        Ok(there)
    }

    fn warnings(&self) -> &[String] {
        self.evaluator.warnings()
    }

    fn specialised_steps(&self) -> u64 {
        self.evaluator.specialised_steps()
    }
}

/// A pseudorandom number that depends only on the episodes.
fn lot(batch: &Batch, group: u32) -> u32 {
    let inputs = batch.part(group..group + 1).inputs();
    pcg4d([inputs[0], inputs[LANES], 0, 0])[3]
}
