//! Runs in progress and the episodes of their individuals.

use oneiro::random::Key;
use oneiro_evolve::Optimizer;
use oneiro_evolve::genetic::Genetic;
use oneiro_lab::reality;

use super::results::{Condition, Level};

/// Identifies an individual's episode, and seeds its random numbers.
#[derive(Clone, Copy)]
pub(super) enum Trial {
    Simulated,
    SimulatedAgain,
    Quiet,
    Real,
    RealAgain,
    OtherRobot,
    /// One of the simulated episodes whose mean decides the champion.
    Reevaluated(u32),
}

impl Trial {
    /// The episode's number. 16 to 31 are for the drives between episodes (`real_episodes`).
    pub(super) fn number(self) -> u64 {
        match self {
            Self::Simulated => 0,
            Self::SimulatedAgain => 1,
            Self::Quiet => 2,
            Self::Real => 3,
            Self::RealAgain => 4,
            Self::OtherRobot => 5,
            Self::Reevaluated(episode) => 32 + u64::from(episode),
        }
    }

    /// For readers: the suffix after the name of a re-evaluated individual.
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

/// Episodes of a run's current generation.
pub(super) fn episodes(run: &Evolving, trial: Trial) -> impl Iterator<Item = reality::Life<'_>> {
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
