//! A run's directory, read again: to resume, replay, audit, verify or list it.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{CONFIG, Done, Meta, Status};
use crate::engine::disk::LOCK;
use crate::exit::{Failure, Result};
use crate::runs::{self, Experiment, Recorded};

/// Whether a directory is a run's.
pub(crate) fn is_run(directory: &Path) -> bool {
    directory.join(CONFIG).is_file()
}

/// A run on disk.
#[derive(Debug)]
pub(crate) struct SavedRun {
    directory: PathBuf,
    experiment: Arc<dyn Experiment>,
    seed: u64,
}

/// Progress of a run on disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    /// Finished and recorded.
    Done,
    /// A process works on it.
    Running,
    /// Stopped by the user.
    Stopped,
    /// Its process ended without saying so.
    Interrupted,
}

/// Whether a process writes to a directory.
pub(crate) fn is_locked(directory: &Path) -> bool {
    File::open(directory.join(LOCK)).is_ok_and(|lock| matches!(lock.try_lock(), Err(TryLockError::WouldBlock)))
}

impl SavedRun {
    /// Opens a run's directory.
    ///
    /// # Errors
    /// Exit 3 if it isn't one, or its configuration is invalid.
    pub(crate) fn open(directory: &Path) -> Result<Self> {
        if !is_run(directory) {
            return Err(Failure::input(format_args!(
                "{}: is not a run directory: there is no {CONFIG} in it",
                directory.display()
            )));
        }
        let config = directory.join(CONFIG);
        let experiment = runs::recorded(&config)?;
        let seed = experiment.seed().ok_or_else(|| {
            Failure::input(format_args!(
                "{}: lacks the key seed, which the configuration of a run has",
                config.display()
            ))
        })?;
        Ok(Self {
            directory: directory.to_owned(),
            experiment,
            seed,
        })
    }

    /// Path of the directory.
    pub(crate) fn directory(&self) -> &Path {
        &self.directory
    }

    /// The experiment's file, with every value written out.
    pub(crate) fn config(&self) -> PathBuf {
        self.directory.join(CONFIG)
    }

    /// Experiment of the run.
    pub(crate) fn experiment(&self) -> &Arc<dyn Experiment> {
        &self.experiment
    }

    pub(crate) fn seed(&self) -> u64 {
        self.seed
    }

    /// Hash of everything that decides its results.
    pub(crate) fn identity(&self) -> blake3::Hash {
        self.experiment.identities().of(self.seed)
    }

    /// Progress of the run.
    pub(crate) fn state(&self) -> Result<State> {
        if Done::read(&self.directory)?.is_some() {
            return Ok(State::Done);
        }
        Ok(match Meta::read(&self.directory) {
            _ if is_locked(&self.directory) => State::Running,
            Some(meta) if meta.status == Status::Stopped => State::Stopped,
            _ => State::Interrupted,
        })
    }

    /// Returns the run if it is finished.
    ///
    /// # Errors
    /// Exit 1 if it isn't.
    pub(crate) fn finished(&self) -> Result<Recorded<'_>> {
        let recorded = self.recorded()?;
        if !recorded.is_done {
            let problem = "is not finished, so it has no champion yet; `oneiro resume` continues it";
            return Err(Failure::failed(format_args!("{}: {problem}", self.directory.display())));
        }
        Ok(recorded)
    }

    /// Returns the run as far as it is recorded.
    ///
    /// # Errors
    /// Exit 5 if the record that it is finished is damaged.
    pub(crate) fn recorded(&self) -> Result<Recorded<'_>> {
        Ok(Recorded {
            directory: &self.directory,
            seed: self.seed,
            is_done: Done::read(&self.directory)?.is_some(),
        })
    }
}
