//! Every individual of a run with its genes and score: `individuals.npy`.

use std::path::Path;

use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::npy;
use oneiro_evolve::Population;

use super::INDIVIDUALS;
use crate::experiment::Experiment;

/// Every individual of a run with its genes and score.
#[derive(Debug)]
pub(crate) struct Individuals {
    genes: usize,
    population: usize,
    values: Vec<f32>,
}

impl Individuals {
    /// The start of the file.
    pub(super) fn header(experiment: &Experiment) -> Vec<u8> {
        let evolution = &experiment.settings().evolution;
        npy::header(&[
            evolution.generations as usize,
            evolution.genomes_per_generation() as usize,
            experiment.world().genes() + 1,
        ])
    }

    /// Reads all recorded individuals.
    ///
    /// # Errors
    /// Exit 1 if the run doesn't record them, exit 5 if the file isn't what was written.
    pub(crate) fn read(directory: &Path, experiment: &Experiment) -> Result<Self> {
        if !experiment.settings().record.individuals {
            let problem = "its individuals were not recorded (record.individuals = false)";
            return Err(Failure::failed(format_args!("{}: {problem}", directory.display())));
        }
        let path = directory.join(INDIVIDUALS);
        let bytes = disk::read(&path)?;
        let Some(values) = bytes.strip_prefix(&Self::header(experiment)[..]) else {
            return Err(Failure::corrupt(format_args!(
                "{}: does not begin as this run's should",
                path.display()
            )));
        };
        Ok(Self {
            genes: experiment.world().genes(),
            population: experiment.settings().evolution.genomes_per_generation() as usize,
            values: npy::floats(values),
        })
    }

    /// Number of individuals in complete generations.
    pub(crate) fn len(&self) -> usize {
        self.values.len() / (self.genes + 1) / self.population * self.population
    }

    /// The genomes of all.
    pub(super) fn genomes(&self) -> Population {
        let rows = self.values.chunks_exact(self.genes + 1).take(self.len());
        Population::new(self.genes, rows.flat_map(|row| &row[..self.genes]).copied().collect())
    }

    /// Generation and number of the index-th individual.
    pub(crate) fn place(&self, index: usize) -> (u32, u32) {
        ((index / self.population) as u32, (index % self.population) as u32)
    }

    /// Genome and score of the index-th individual, counted through all generations.
    pub(crate) fn get(&self, index: usize) -> Option<(&[f32], f32)> {
        let own = self.values.get(index * (self.genes + 1)..)?.get(..=self.genes)?;
        Some((&own[..self.genes], own[self.genes]))
    }
}
