//! A device's results, some of them computed again on the CPU and compared bit for bit.

use oneiro_shaders::life::Record;

use crate::batch::{Batch, LANES, Part};
use crate::cpu::Cpu;
use crate::evaluator::{Control, Device, Error, Evaluator, PartResult};
use crate::random::pcg4d;

/// An evaluator whose results are audited: of each call, a share of the groups of 64 rollouts is run again on the
/// CPU. Which ones depends on the rollouts' keys alone.
pub struct Audited {
    evaluator: Box<dyn Evaluator>,
    cpu: Cpu,
    share: f64,
}

impl Audited {
    /// Audits a share from 0 (none) to 1 (all) of an evaluator's groups, if it is not 0 at least one a call.
    pub fn new(evaluator: Box<dyn Evaluator>, cpu: Cpu, share: f64) -> Self {
        Self { evaluator, cpu, share }
    }

    /// The groups of a part that are run again.
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
        let there = self.evaluator.evaluate_part(part, control)?;
        let chosen = self.chosen(part);
        let here = self.cpu.run(part.batch(), &chosen, control, false)?;
        let records = part.trace_records() as usize;
        for (index, group) in chosen.into_iter().enumerate() {
            let rollouts = part.batch().part(group..group + 1).rollouts();
            for lane in 0..rollouts {
                let slot = (group - part.groups().start) as usize * LANES + lane;
                let own = index * LANES + lane;
                let fitness = (there.fitness[slot], here.fitness[own]);
                let trace = (
                    &there.trace[slot * records..][..records],
                    &here.trace[own * records..][..records],
                );
                if let Some((there, here)) = difference(fitness, trace) {
                    let rollout = part.batch().rollout(group as usize * LANES + lane).unwrap_or_default();
                    return Err(Error::Differs {
                        rollout,
                        device: self.device().name,
                        there,
                        here,
                    });
                }
            }
        }
        Ok(there)
    }

    fn warnings(&self) -> &[String] {
        self.evaluator.warnings()
    }
}

/// A number that is as good as random, and the same for the same rollouts.
fn lot(batch: &Batch, group: u32) -> u32 {
    let inputs = batch.part(group..group + 1).inputs();
    pcg4d([inputs[0], inputs[LANES], 0, 0])[3]
}

/// The first numbers with other bits.
fn difference(fitness: (f32, f32), trace: (&[Record], &[Record])) -> Option<(f32, f32)> {
    let there: &[f32] = bytemuck::cast_slice(trace.0);
    let here: &[f32] = bytemuck::cast_slice(trace.1);
    let numbers = std::iter::once(fitness).chain(there.iter().copied().zip(here.iter().copied()));
    numbers
        .into_iter()
        .find(|(there, here)| there.to_bits() != here.to_bits())
}
