//! Runs in progress and the lives of their individuals.

use oneiro::random::Key;
use oneiro_evolve::Optimizer;
use oneiro_evolve::genetic::Genetic;
use oneiro_lab::reality;

use super::results::{Condition, Level};

/// Identifies one life of an individual; each has random numbers of its own.
#[derive(Clone, Copy)]
pub(super) enum Trial {
    Simulated,
    SimulatedAgain,
    Quiet,
    Real,
    RealAgain,
    OtherRobot,
    /// One of the simulated lives whose mean decides the champion.
    Appraised(u32),
}

impl Trial {
    /// Number of the life. 16 to 31 are taken by the drives between lives (`real_lives`).
    pub(super) fn number(self) -> u64 {
        match self {
            Self::Simulated => 0,
            Self::SimulatedAgain => 1,
            Self::Quiet => 2,
            Self::Real => 3,
            Self::RealAgain => 4,
            Self::OtherRobot => 5,
            Self::Appraised(life) => 32 + u64::from(life),
        }
    }

    /// What follows the name of an individual that lives again, for readers.
    pub(super) fn again(self) -> &'static str {
        match self {
            Self::RealAgain => ", again",
            _ => "",
        }
    }
}

/// A run in progress.
#[derive(Clone)]
pub(super) struct Evolving {
    pub(super) condition: Condition,
    pub(super) number: u32,
    pub(super) seed: u64,
    pub(super) evolution: Genetic,
    pub(super) simulated: Vec<Level>,
    pub(super) real: Vec<Level>,
}

/// Lives of a run's current generation.
pub(super) fn lives(run: &Evolving, trial: Trial) -> impl Iterator<Item = reality::Life<'_>> {
    let generation = u64::from(run.evolution.generation());
    run.evolution
        .ask()
        .genomes()
        .zip(0..)
        .map(move |(genes, individual)| reality::Life {
            genes,
            key: Key::rollout(run.seed, generation, individual, trial.number()),
            start: None,
        })
}

/// Splits a batch's fitness by run.
pub(super) fn by_run(runs: &[Evolving], fitness: Vec<f32>) -> Vec<Vec<f32>> {
    let mut rest = fitness.into_iter();
    runs.iter()
        .map(|run| rest.by_ref().take(run.evolution.ask().len()).collect())
        .collect()
}
