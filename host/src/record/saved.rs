//! A run's directory, read again: to go on with it, to replay, audit, verify or list it.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use super::{CONFIG, Done, GENERATIONS, INDIVIDUALS, LOCK, Meta, Row, Status, champion, disk};
use crate::evolve::Champion;
use crate::exit::{Failure, Result};
use crate::experiment::Experiment;

/// Whether a directory is a run's.
pub(crate) fn is_run(directory: &Path) -> bool {
    directory.join(CONFIG).is_file()
}

/// A run as it is on the disk.
#[derive(Debug)]
pub(crate) struct SavedRun {
    directory: PathBuf,
    experiment: Experiment,
    seed: u64,
}

/// How far a run on the disk is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    /// Finished.
    Done,
    /// A process works on it.
    Running,
    /// Stopped by the user.
    Stopped,
    /// Its process ended without saying so.
    Interrupted,
}

/// The seed that a run's configuration has.
pub(super) fn seed_of(config: &Path, seed: Option<u64>) -> Result<u64> {
    seed.ok_or_else(|| {
        Failure::input(format_args!(
            "{}: there is no key seed; a run's has one",
            config.display()
        ))
    })
}

/// Whether a process writes to a directory.
pub(crate) fn is_locked(directory: &Path) -> bool {
    File::open(directory.join(LOCK)).is_ok_and(|lock| matches!(lock.try_lock(), Err(TryLockError::WouldBlock)))
}

/// How far a run of any kind is.
pub(super) fn state(directory: &Path) -> Result<State> {
    if Done::read(directory)?.is_some() {
        return Ok(State::Done);
    }
    Ok(match Meta::read(directory) {
        _ if is_locked(directory) => State::Running,
        Some(meta) if meta.status == Status::Stopped => State::Stopped,
        _ => State::Interrupted,
    })
}

impl SavedRun {
    /// Opens a run's directory.
    ///
    /// # Errors
    /// Exit 3 when it is none, or its configuration is invalid.
    pub(crate) fn open(directory: &Path) -> Result<Self> {
        if !is_run(directory) {
            return Err(Failure::input(format_args!(
                "{}: is no run's directory: there is no {CONFIG} in it",
                directory.display()
            )));
        }
        let config = directory.join(CONFIG);
        let experiment = Experiment::read(&config, &[])?;
        let seed = seed_of(&config, experiment.settings().seed)?;
        Ok(Self {
            directory: directory.to_owned(),
            experiment,
            seed,
        })
    }

    /// Where it is.
    pub(crate) fn directory(&self) -> &Path {
        &self.directory
    }

    /// What it is a run of.
    pub(crate) fn experiment(&self) -> &Experiment {
        &self.experiment
    }

    /// Its seed.
    pub(crate) fn seed(&self) -> u64 {
        self.seed
    }

    /// How far it is.
    pub(crate) fn state(&self) -> Result<State> {
        state(&self.directory)
    }

    /// The generations that are recorded.
    ///
    /// # Errors
    /// Exit 5 with the line that is none.
    pub(crate) fn rows(&self) -> Result<Vec<Row>> {
        rows(&self.directory)
    }

    /// The champion of a finished run.
    ///
    /// # Errors
    /// Exit 1 when the run is not finished, exit 5 when the files are not what was written.
    pub(crate) fn champion(&self) -> Result<Champion> {
        if Done::read(&self.directory)?.is_none() {
            let problem = "is not finished, so it has no champion yet; `oneiro resume` goes on with it";
            return Err(Failure::failed(format_args!("{}: {problem}", self.directory.display())));
        }
        champion::read(&self.directory, self.experiment.world().genes())
    }

    /// All individuals that are recorded.
    ///
    /// # Errors
    /// Exit 1 when the run does not record them, exit 5 when the file is none of theirs.
    pub(crate) fn individuals(&self) -> Result<Individuals> {
        if !self.experiment.settings().record.individuals {
            let problem = "its individuals were not recorded (record.individuals = false)";
            return Err(Failure::failed(format_args!("{}: {problem}", self.directory.display())));
        }
        let path = self.directory.join(INDIVIDUALS);
        let bytes = disk::read(&path)?;
        let header = Individuals::header(&self.experiment);
        let Some(values) = bytes.strip_prefix(&header[..]) else {
            return Err(Failure::corrupt(format_args!(
                "{}: does not begin as this run's should",
                path.display()
            )));
        };
        Ok(Individuals {
            genes: self.experiment.world().genes(),
            population: self.experiment.settings().evolution.population as usize,
            values: super::floats(values),
        })
    }
}

/// The generations that are recorded in a run's directory.
///
/// # Errors
/// Exit 5 with the line that is none.
pub(crate) fn rows(directory: &Path) -> Result<Vec<Row>> {
    let path = directory.join(GENERATIONS);
    let rows = Row::parse(&disk::read_text(&path)?);
    rows.map_err(|problem| Failure::corrupt(format_args!("{}: {problem}", path.display())))
}

/// Every individual of a run, its genes and its score.
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
        super::npy_header(&[
            evolution.generations as usize,
            evolution.population as usize,
            experiment.world().genes() + 1,
        ])
    }

    /// How many there are, in whole generations.
    pub(crate) fn len(&self) -> usize {
        self.values.len() / (self.genes + 1) / self.population * self.population
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
