//! An evolution on a robot's computer while the robot runs: one generation after the other, and the best of the last one for the
//! robot to try.

use std::sync::Arc;

use oneiro::batch::Worlds;
use oneiro::evaluator::{Control, Evaluator};
use oneiro_base::exit::{Failure, Result};
use oneiro_evolve::Champion;

use super::Single;
use super::job::Evolving;
use crate::engine::job::{Job, Results};
use crate::experiment::Experiment;
use crate::runs::Recording;

/// Episodes between two rests of the processor: as many as a batch of the widest lane code.
const LIVES: usize = 64;

/// The simulated part of a run, without its files and its finalists.
pub struct OnBoard {
    job: Evolving,
    worlds: Worlds,
}

impl OnBoard {
    /// A run's evolution before its first generation, or from where it was saved.
    ///
    /// # Errors
    /// Exit 3 for a value that the world doesn't allow; exit 5 if the bytes aren't what [`OnBoard::save`] returns for this run.
    pub fn new(experiment: Experiment, seed: u64, saved: Option<&[u8]>) -> Result<Self> {
        let worlds = Worlds::new(std::slice::from_ref(experiment.world()))?;
        let job = Evolving::new(Arc::new(Single::new(experiment, None)), seed, Recording::Tables)?;
        let job = match saved {
            Some(saved) => job.restored(saved)?,
            None => job,
        };
        Ok(Self { job, worlds })
    }

    /// Evaluates a generation and breeds the next one. `rest` is called after every few episodes.
    ///
    /// # Errors
    /// Those of the evaluator.
    pub fn breed(&mut self, device: &mut dyn Evaluator, rest: &mut dyn FnMut()) -> Result {
        let request = self.job.ask().filter(|_| !self.is_over());
        let request = request.ok_or_else(|| Failure::failed("the evolution is over"))?;
        let trace = request.stage.trace();
        let (mut rollouts, mut fitness, mut traces) = (Vec::new(), Vec::new(), Vec::new());
        self.job.rollouts(&mut rollouts);
        for lives in rollouts.chunks(LIVES) {
            let batch = self.worlds.batch(lives, trace)?;
            let outcome = device.evaluate(&batch, &Control::new())?;
            fitness.extend(outcome.fitness);
            traces.extend(outcome.traces);
            rest();
        }
        let results = Results {
            fitness: &fitness,
            traces: &traces,
            logs: &[],
            log_words: 0,
            states: &[],
        };
        self.job.bred_anew(&results).map(drop)
    }

    /// The best of the generation that was evaluated last; none before the first.
    pub fn best(&self) -> Option<&Champion> {
        self.job.luckiest().ok()
    }

    /// Number of generations that have been evaluated.
    pub fn generation(&self) -> u32 {
        self.job.generation()
    }

    /// Whether all generations have been evaluated.
    pub fn is_over(&self) -> bool {
        self.job.is_over()
    }

    /// Everything that is needed to continue.
    pub fn save(&self) -> Vec<u8> {
        self.job.save()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use oneiro::cpu::Cpu;

    use super::*;
    use crate::experiment::Files;
    use crate::experiment::source::Parsed;

    fn evolution(more: &str, saved: Option<&[u8]>) -> OnBoard {
        let text = format!("cycles = 20\n[evolution]\npopulation = 80\nparents = 10\ngenerations = 4\n{more}");
        let parsed = Parsed::new("small.toml".into(), &text).unwrap();
        let experiment = Experiment::of(Path::new("small.toml"), &parsed, &[], &Files::default()).unwrap();
        OnBoard::new(experiment, 3, saved).unwrap()
    }

    fn bred(own: &mut OnBoard) -> Vec<Champion> {
        let mut cpu = Cpu::new(Some(1)).unwrap();
        let mut best = Vec::new();
        while !own.is_over() {
            let mut lives = 0;
            own.breed(&mut cpu, &mut || lives += 1).unwrap();
            assert_eq!(lives, 2, "80 lives, 64 at a time");
            best.push(own.best().unwrap().clone());
        }
        best
    }

    /// The best of a generation depends on that generation only, and a saved evolution continues as if it had not been
    /// interrupted.
    #[test]
    fn an_evolution_goes_on_from_where_it_was_saved() {
        let mut whole = evolution("", None);
        let best = bred(&mut whole);
        assert_eq!(best.iter().map(|own| own.generation).collect::<Vec<_>>(), [0, 1, 2, 3]);
        let mut cpu = Cpu::new(Some(1)).unwrap();
        let mut first = evolution("", None);
        first.breed(&mut cpu, &mut || ()).unwrap();
        assert_eq!((first.best(), first.generation()), (best.first(), 1));
        let mut second = evolution("", Some(&first.save()));
        assert_eq!(second.best(), best.first());
        assert_eq!(bred(&mut second), best[1..]);
        assert!(whole.breed(&mut cpu, &mut || ()).is_err());
    }

    /// Any optimiser is possible, also one that uses individuals' behaviour.
    #[test]
    fn optimisers_that_use_behaviour_evolve_on_board() {
        let more =
            "kind = \"novelty\"\n[[evolution.descriptors]]\nmeasure = \"end_x_mm\"\nleast = 0.0\ngreatest = 600.0\n";
        let best = bred(&mut evolution(more, None));
        assert_eq!(best.len(), 4);
    }
}
