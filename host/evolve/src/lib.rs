//! Evolution: optimisers that name the genomes to evaluate next and take their fitness. Nothing here depends on robots,
//! devices or files.

// Only this workspace uses it.
#![allow(
    missing_docs,
    clippy::missing_errors_doc,
    clippy::missing_panics_doc,
    clippy::return_self_not_must_use,
    rustdoc::private_intra_doc_links,
    reason = "items whose names do not say everything are documented"
)]
// `clippy.toml` says what has one place only.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub mod appraisal;
mod cma;
pub mod coevolution;
mod differential_evolution;
pub mod encapsulated;
mod error;
pub mod genetic;
mod grid;
pub mod map_elites;
mod novelty;
mod open_es;
pub mod race;
pub mod random;
mod random_search;
mod registry;
mod saved;
pub mod settings;

pub use error::{Error, Result};

#[cfg(test)]
#[path = "../../../tests/pinned/mod.rs"]
mod pinned;

use std::cmp::Ordering;
use std::fmt::Debug;

use oneiro::parameter::{Choice, Choices, Parameter};
use oneiro::world::Gene;
use serde::{Deserialize, Serialize};

use coevolution::Coevolution;
use map_elites::Archive;
use race::Round;
use registry::{Beginning, Entry, Table, optimisers};
pub use settings::GivenGenomes;
use settings::Settings;

// The registry, in the order of documents and messages.
optimisers! {
    Genetic: genetic::ENTRY;
    CmaEs: cma::FULL;
    SepCmaEs: cma::DIAGONAL;
    OpenEs: open_es::ENTRY;
    MapElites: map_elites::ENTRY, archive: map_elites::Values;
    Novelty: novelty::ENTRY, novelty: novelty::Values;
    Random: random_search::ENTRY;
    Grid: grid::ENTRY, grid: grid::Values;
    Race: race::ENTRY, race: race::Values;
    Coevolution: coevolution::ENTRY, opponents: coevolution::Values;
    DifferentialEvolution: differential_evolution::ENTRY, differential: differential_evolution::Values;
}

#[expect(clippy::derivable_impls, reason = "the registry's lines have no attributes")]
impl Default for Kind {
    fn default() -> Self {
        Self::Genetic
    }
}

/// Genomes of equal length, one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Population {
    genes: usize,
    values: Vec<f32>,
}

impl Population {
    /// Genomes of `genes` genes each, one after the other; the number of values is a multiple of `genes`.
    pub fn new(genes: usize, values: Vec<f32>) -> Self {
        debug_assert!(genes > 0 && values.len().is_multiple_of(genes), "whole genomes");
        Self { genes, values }
    }

    /// Genes of a genome.
    pub fn genes(&self) -> usize {
        self.genes
    }

    /// Individuals.
    #[expect(clippy::len_without_is_empty, reason = "no population is empty")]
    pub fn len(&self) -> usize {
        self.values.len() / self.genes
    }

    /// The genomes in order.
    pub fn genomes(&self) -> impl Iterator<Item = &[f32]> {
        self.values.chunks_exact(self.genes)
    }

    /// An individual's genome.
    pub fn genome(&self, individual: usize) -> &[f32] {
        &self.values[individual * self.genes..][..self.genes]
    }

    /// All genes, genome by genome.
    pub fn values(&self) -> &[f32] {
        &self.values
    }
}

/// The luckiest episode of a run so far: the best score of any individual in any generation. With noise or random
/// starts, it says less about a controller than the mean of many episodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Champion {
    /// Generation.
    pub generation: u32,
    /// Index in its generation.
    pub individual: u32,
    /// Its score.
    pub fitness: f32,
    /// Its genes.
    pub genome: Vec<f32>,
}

impl Champion {
    /// Whether both are the same individual of the same generation.
    fn is_individual(&self, other: &Self) -> bool {
        (self.generation, self.individual) == (other.generation, other.individual)
    }

    /// Its genome as a population of one.
    pub fn alone(self) -> Population {
        Population::new(self.genome.len(), self.genome)
    }
}

/// A generation that was evaluated.
#[derive(Clone, Debug)]
pub struct Generation {
    /// Its number, from 0.
    pub number: u32,
    /// Its genomes.
    pub population: Population,
    /// Their scores.
    pub fitness: Vec<f32>,
    /// Indices from the best to the worst: of equals, the lower index first; NaN last.
    pub ranking: Vec<u32>,
}

impl Generation {
    /// Individuals whose score is NaN: the last of the ranking.
    #[cfg(test)]
    pub fn nan(&self) -> usize {
        self.fitness.iter().filter(|score| score.is_nan()).count()
    }
}

/// An algorithm that improves genomes by their fitness, generation after generation.
pub trait Optimizer: Debug + Send + Sync {
    /// The algorithm's name.
    fn name(&self) -> &'static str;

    /// Whether it computes the same bits on every machine.
    fn is_exact(&self) -> bool {
        true
    }

    /// Number of the generation that is to be evaluated next, from 0.
    fn generation(&self) -> u32;

    /// The genomes to evaluate next. They depend only on the state: another call, also after [`Optimizer::restore`],
    /// returns the same.
    fn ask(&self) -> &Population;

    /// Numbers that describe the behaviour of each individual, which [`Optimizer::tell`] takes.
    fn descriptors(&self) -> usize {
        0
    }

    /// The elites of an optimiser that keeps some.
    fn archive(&self) -> Option<&Archive> {
        None
    }

    /// The genome around which a strategy samples, and its step size in halves of the genes' initial ranges.
    fn distribution(&self) -> Option<(Vec<f32>, f64)> {
        None
    }

    /// The two populations of one that has them.
    fn coevolution(&self) -> Option<&Coevolution> {
        None
    }

    /// What the last generation was for the candidates of a race.
    fn round(&self) -> Option<Round> {
        None
    }

    /// Whether its budget is spent.
    fn is_over(&self) -> bool {
        false
    }

    /// Individuals to re-evaluate after the last generation, the best first, without the run's luckiest: those of that
    /// generation, whose genomes and fitness are given, unless the optimiser has better ones.
    fn finalists<'a>(&'a self, luckiest: &'a Champion, genomes: &'a [f32], fitness: &'a [f32]) -> Finalists<'a> {
        let generation = self.generation() - 1;
        let genes = genomes.len() / fitness.len();
        let others = ranked(fitness).into_iter().map(move |individual| Champion {
            generation,
            individual,
            fitness: fitness[individual as usize],
            genome: genomes[individual as usize * genes..][..genes].to_vec(),
        });
        Box::new(others.filter(|champion| !champion.is_individual(luckiest)))
    }

    /// Takes the fitness of [`Optimizer::ask`]'s genomes, in their order, and what describes the behaviour of each, and makes the
    /// next generation. Fitness is maximised; NaN ranks last.
    ///
    /// # Errors
    /// Another number of scores or of descriptors than genomes have; then nothing has changed.
    fn tell(&mut self, fitness: Vec<f32>, behaviour: &[f64]) -> Result<Generation> {
        let (number, individuals) = (self.generation(), self.ask().len());
        if fitness.len() != individuals {
            return Err(Error::Scores {
                generation: number,
                scores: fitness.len(),
                individuals,
            });
        }
        let descriptors = individuals * self.descriptors();
        if behaviour.len() != descriptors {
            return Err(Error::Descriptors {
                generation: number,
                numbers: behaviour.len(),
                individuals,
                allowed: descriptors,
            });
        }
        let ranking = ranked(&fitness);
        Ok(Generation {
            number,
            population: self.advance(&fitness, &ranking, behaviour),
            fitness,
            ranking,
        })
    }

    /// Makes the next generation, like [`Optimizer::tell`], and returns the evaluated one. All counts are right, and
    /// `ranking` is that of [`ranked`].
    fn advance(&mut self, fitness: &[f32], ranking: &[u32], behaviour: &[f64]) -> Population;

    /// Changes how many generations the experiment of its saved states has. Where its course depends on that number
    /// ([`Settings::is_open_ended`] is false), the results are not those of an evolution that had the number from the start.
    fn set_generations(&mut self, generations: u32);

    /// Its whole state, sealed with its name, version and a hash of its settings.
    fn save(&self) -> Vec<u8>;

    /// Continues from a saved state.
    ///
    /// # Errors
    /// A state that is damaged, or of another algorithm, version or settings; then nothing has changed.
    fn restore(&mut self, saved: &[u8]) -> Result;
}

/// The optimiser that an experiment chooses, before its first generation; `genes` are the controller's, and `init` the genomes to
/// begin with, if they are given.
pub fn optimizer(settings: &Settings, seed: u64, genes: &[Gene], init: Option<Population>) -> Box<dyn Optimizer> {
    (settings.kind.entry().begin)(Beginning {
        settings,
        seed,
        genes,
        init,
    })
}

/// What an optimiser makes of given genomes.
pub fn given_genomes(settings: &Settings) -> GivenGenomes {
    settings.kind.entry().start
}

/// How many genomes an optimiser may be given to begin with; `None`: any number.
pub fn most_given(settings: &Settings, genes: &[Gene]) -> Option<usize> {
    match (settings.kind, settings.kind.entry().start) {
        (_, GivenGenomes::None(_)) => Some(0),
        (_, GivenGenomes::Mean) => None,
        // The first race may have fewer candidates than the largest.
        (Kind::Race, _) => Some(optimizer(settings, 0, genes, None).ask().len()),
        (_, GivenGenomes::First(_)) => Some(settings.population as usize),
    }
}

/// One run's evolution: an optimiser, for a number of generations, and the luckiest episode so far.
#[derive(Debug)]
pub struct Evolution {
    optimizer: Box<dyn Optimizer>,
    generations: u32,
    champion: Option<Champion>,
}

impl Evolution {
    /// Evolves with an optimiser for `generations` generations. `champion` is that of earlier generations, if any.
    pub fn new(optimizer: Box<dyn Optimizer>, generations: u32, champion: Option<Champion>) -> Self {
        Self {
            optimizer,
            generations,
            champion,
        }
    }

    /// The algorithm.
    pub fn optimizer(&self) -> &dyn Optimizer {
        &*self.optimizer
    }

    /// Number of the generation that is to be evaluated next; when all have been, how many there are.
    pub fn generation(&self) -> u32 {
        self.optimizer.generation()
    }

    /// Whether all generations have been evaluated.
    pub fn is_finished(&self) -> bool {
        self.generation() >= self.generations || self.optimizer.is_over()
    }

    /// The genomes to evaluate next.
    pub fn ask(&self) -> &Population {
        self.optimizer.ask()
    }

    /// The luckiest episode so far; none before the first generation was evaluated.
    pub fn champion(&self) -> Option<&Champion> {
        self.champion.as_ref()
    }

    /// Takes the fitness of [`Evolution::ask`]'s genomes, and what describes their behaviour.
    ///
    /// # Errors
    /// As [`Optimizer::tell`].
    pub fn tell(&mut self, fitness: Vec<f32>, behaviour: &[f64]) -> Result<Generation> {
        let generation = self.optimizer.tell(fitness, behaviour)?;
        let best = generation.ranking[0];
        let fitness = generation.fitness[best as usize];
        let is_better = |champion: &Champion| by_fitness(fitness, champion.fitness).is_lt();
        if let Some(coevolution) = self.optimizer.coevolution() {
            // Scores of different generations can't be compared.
            self.champion = Some(coevolution.pair());
        } else if self.champion.as_ref().is_none_or(is_better) {
            self.champion = Some(Champion {
                generation: generation.number,
                individual: best,
                fitness,
                genome: generation.population.genome(best as usize).to_vec(),
            });
        }
        Ok(generation)
    }

    /// Gives it another number of generations.
    pub fn set_generations(&mut self, generations: u32) {
        self.generations = generations;
        self.optimizer.set_generations(generations);
    }

    /// Gives the champion the fitness of extra episodes, where its generation had none.
    pub fn exhibit(&mut self, fitness: f32) {
        if let Some(champion) = &mut self.champion {
            champion.fitness = fitness;
        }
    }

    /// Restarts the search for the luckiest episode: earlier ones can't be compared with later ones.
    pub fn forget_champion(&mut self) {
        self.champion = None;
    }

    /// All that it needs to continue.
    pub fn save(&self) -> SavedEvolution {
        SavedEvolution {
            optimizer: self.optimizer.save(),
            champion: self.champion.clone(),
        }
    }

    /// Continues from a saved state.
    ///
    /// # Errors
    /// As [`Optimizer::restore`].
    pub fn restore(&mut self, saved: SavedEvolution) -> Result {
        self.optimizer.restore(&saved.optimizer)?;
        self.champion = saved.champion;
        Ok(())
    }
}

/// An [`Evolution`] between two generations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedEvolution {
    optimizer: Vec<u8>,
    champion: Option<Champion>,
}

/// The better first; NaN is worse than every number.
pub fn by_fitness(a: f32, b: f32) -> Ordering {
    b.partial_cmp(&a).unwrap_or_else(|| a.is_nan().cmp(&b.is_nan()))
}

/// What [`Optimizer::finalists`] returns.
pub type Finalists<'a> = Box<dyn Iterator<Item = Champion> + 'a>;

/// Indices from the best to the worst, by [`by_fitness`]; of equals, the lower index first.
pub fn ranked(fitness: &[f32]) -> Vec<u32> {
    // Whole numbers of the same order are sorted several times as fast: the place of a score, then its index.
    let mut places: Vec<u64> = fitness
        .iter()
        .zip(0_u64..)
        .map(|(&fitness, index)| u64::from(descending(fitness)) << 32 | index)
        .collect();
    places.sort_unstable();
    places.into_iter().map(|place| place as u32).collect()
}

/// A number that is the lower, the higher a score is: equal for zeros of either sign, and highest for NaN.
fn descending(fitness: f32) -> u32 {
    if fitness.is_nan() {
        return u32::MAX;
    }
    // The bits of positive numbers ascend with them, those of negative ones descend.
    let bits = (fitness + 0.0).to_bits();
    if bits >> 31 == 1 { bits } else { !bits ^ 1 << 31 }
}

#[cfg(test)]
mod tests;
