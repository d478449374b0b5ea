//! Every individual of a run with its genes and score: `individuals.npy`.

use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::npy;
use oneiro_base::plain;
use oneiro_evolve::{Champion, Population};

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

    /// Reads one generation of a run that may still be written: the given one, or the newest that is complete. `None` if there is none,
    /// or individuals are not recorded.
    ///
    /// # Errors
    /// Exit 6 if the file can't be read.
    pub(super) fn of_one(
        directory: &Path,
        experiment: &Experiment,
        generation: Option<u32>,
    ) -> Result<Option<(u32, Self)>> {
        let path = directory.join(INDIVIDUALS);
        let genes = experiment.world().genes();
        let population = experiment.settings().evolution.genomes_per_generation() as usize;
        let header = Self::header(experiment).len() as u64;
        let each = (population * (genes + 1) * size_of::<f32>()) as u64;
        let read = || -> io::Result<Option<(u32, Vec<u8>)>> {
            let mut file = match plain::open_table(&path) {
                Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
                file => file?,
            };
            let complete = file.metadata()?.len().saturating_sub(header) / each;
            let last = complete.checked_sub(1);
            let Some(number) = generation.map_or(last, |own| {
                last.filter(|last| u64::from(own) <= *last).map(|_| own.into())
            }) else {
                return Ok(None);
            };
            file.seek(SeekFrom::Start(header + number * each))?;
            let mut bytes = vec![0; each as usize];
            file.read_exact(&mut bytes)?;
            Ok(Some((number as u32, bytes)))
        };
        let read = read().map_err(|error| Failure::storage(&path, &error))?;
        Ok(read.map(|(number, bytes)| {
            let values = npy::floats(&bytes);
            (
                number,
                Self {
                    genes,
                    population,
                    values,
                },
            )
        }))
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

    /// A recorded individual of a generation: the given one, or its best, the first of equals.
    ///
    /// # Errors
    /// Exit 3 if there is no such generation or individual.
    pub(super) fn of_generation(&self, generation: u32, individual: Option<u32>) -> Result<Champion> {
        let (generations, population) = (self.len() / self.population, self.population);
        if generation as usize >= generations {
            return Err(Failure::input(format_args!(
                "--generation {generation}: is not recorded; allowed: 0 to {}",
                generations.saturating_sub(1)
            )));
        }
        if let Some(individual) = individual.filter(|individual| *individual as usize >= population) {
            return Err(Failure::input(format_args!(
                "--individual {individual}: no such individual; allowed: 0 to {}",
                population - 1
            )));
        }
        let all = (0..population as u32).filter(|number| individual.is_none_or(|individual| individual == *number));
        let recorded = all.filter_map(|number| {
            let (genome, fitness) = self.get(generation as usize * population + number as usize)?;
            Some(Champion {
                generation,
                individual: number,
                fitness,
                genome: genome.to_vec(),
            })
        });
        let is_better = |one: &Champion, other: &Champion| {
            other.fitness > one.fitness || (one.fitness.is_nan() && !other.fitness.is_nan())
        };
        let best = recorded.reduce(|one, other| if is_better(&one, &other) { other } else { one });
        best.ok_or_else(|| Failure::corrupt("the generation has no individuals"))
    }

    /// Genome and score of the index-th individual, counted through all generations.
    pub(crate) fn get(&self, index: usize) -> Option<(&[f32], f32)> {
        let own = self.values.get(index * (self.genes + 1)..)?.get(..=self.genes)?;
        Some((&own[..self.genes], own[self.genes]))
    }
}
