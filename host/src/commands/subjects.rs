//! Genomes that a command line names: files, and runs.

use std::path::PathBuf;

use oneiro::world::Controller;

use super::list;
use crate::evolve::Population;
use crate::exit::{Failure, Result};
use crate::experiment::Experiment;
use crate::genomes;
use crate::record::SingleRun;

/// Genomes, and where each comes from.
pub(super) struct Subjects {
    pub(super) genomes: Population,
    /// The path that names it, with its row where there are several: `genomes.npy[3]`.
    pub(super) sources: Vec<String>,
}

/// What was named.
pub(super) enum Named {
    /// A file of genomes.
    File(PathBuf),
    /// A run of single robots.
    Run(Box<SingleRun>),
}

impl Named {
    /// Looks at paths: a directory is a run's, or one that holds runs, which are then taken in the order of their numbers.
    ///
    /// # Errors
    /// Exit 3: a directory without a run, or the run of a swarm.
    pub(super) fn all(paths: &[PathBuf]) -> Result<Vec<Self>> {
        let mut all = Vec::new();
        for path in paths {
            if path.is_dir() {
                for directory in list::runs(path)? {
                    all.push(Self::Run(Box::new(SingleRun::open(&directory)?)));
                }
            } else {
                all.push(Self::File(path.clone()));
            }
        }
        Ok(all)
    }
}

/// The experiment that some runs have in common, with settings that go before its values.
///
/// # Errors
/// Exit 2 where something that is no run is among them; exit 3 where their worlds or their numbers of trials differ.
pub(super) fn common_experiment(named: &[Named], set: &[String]) -> Result<Experiment> {
    let mut runs = Vec::with_capacity(named.len());
    for named in named {
        match named {
            Named::Run(run) => runs.push(run),
            Named::File(path) => {
                return Err(Failure::usage(format_args!(
                    "{}: says nothing of its experiment; allowed: genomes from run directories only, or an experiment \
                     before --genomes",
                    path.display()
                )));
            }
        }
    }
    let lives = |run: &SingleRun| {
        let experiment = run.experiment().ok()?;
        let settings = experiment.settings();
        Some((experiment.world_identity(), settings.trials, settings.trial_score))
    };
    if let Some(other) = runs.iter().find(|run| lives(run) != lives(runs[0])) {
        return Err(Failure::input(format_args!(
            "{} and {} are runs of different worlds or trials; allowed: runs of one experiment, or an experiment before \
             --genomes, such as {}",
            runs[0].directory().display(),
            other.directory().display(),
            runs[0].config().display()
        )));
    }
    Experiment::read(&runs[0].config(), set)
}

impl Subjects {
    /// Reads the genomes, for a controller: of runs their champions, or their last generations.
    ///
    /// # Errors
    /// As [`genomes::read`]; exit 3 where a run's controller takes another number of genes; as [`SingleRun::champion`].
    pub(super) fn read(named: &[Named], controller: Controller, last_generations: bool) -> Result<Self> {
        let genes = controller.genes();
        let (mut values, mut sources) = (Vec::new(), Vec::new());
        for named in named {
            let (path, population) = match named {
                Named::File(path) => (path.as_path(), genomes::read(path, controller)?),
                Named::Run(run) => {
                    let population = if last_generations {
                        run.population()?
                    } else {
                        let genome = run.champion()?.genome;
                        Population::new(genome.len(), genome)
                    };
                    (run.directory(), population)
                }
            };
            if population.genes() != genes {
                return Err(Failure::input(format_args!(
                    "{}: its genomes have {} genes; allowed: {genes}, as the experiment's controller takes",
                    path.display(),
                    population.genes()
                )));
            }
            let path = path.display();
            match population.len() {
                1 => sources.push(path.to_string()),
                rows => sources.extend((0..rows).map(|row| format!("{path}[{row}]"))),
            }
            values.extend_from_slice(population.values());
        }
        Ok(Self {
            genomes: Population::new(genes, values),
            sources,
        })
    }
}
