//! A run's directory, read again: to resume, replay, audit, verify or list it.

use std::fs::TryLockError;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use oneiro_base::disk::LOCK;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files::directory::Holds;
use oneiro_base::plain;

use super::recorder::newest_job;
use super::{CONFIG, Done, FORM, Meta, Status};
use crate::engine::handle::Engine;
use crate::experiment::kinds::is_run;
use crate::runs::{self, Experiment, Recorded, Scene};

/// A run on disk.
#[derive(Debug)]
pub struct SavedRun {
    directory: PathBuf,
    experiment: Arc<dyn Experiment>,
    seed: u64,
}

/// Progress of a run on disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Finished and recorded.
    Done,
    /// A process works on it.
    Running,
    /// Stopped by the user.
    Stopped,
    /// Its process ended without recording that.
    Interrupted,
}

/// Whether a process writes to a directory.
pub fn is_locked(directory: &Path) -> bool {
    plain::open(&directory.join(LOCK)).is_ok_and(|lock| matches!(lock.try_lock(), Err(TryLockError::WouldBlock)))
}

impl SavedRun {
    /// Opens a run's directory.
    ///
    /// # Errors
    /// Exit 3 if it isn't one, or its configuration is invalid.
    pub fn open(directory: &Path) -> Result<Self> {
        if !is_run(directory) {
            let begun = match FORM.look(directory) {
                Ok(Holds::Nothing) if directory.join(LOCK).exists() => {
                    "; its process ended before it was one: repeat the command that began it"
                }
                _ => "",
            };
            return Err(Failure::input(format_args!(
                "{}: is not a run directory: there is no {CONFIG} in it{begun}",
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
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// The experiment's file, with every value written out.
    pub fn config(&self) -> PathBuf {
        self.directory.join(CONFIG)
    }

    /// Experiment of the run.
    pub fn experiment(&self) -> &Arc<dyn Experiment> {
        &self.experiment
    }

    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Hash of everything that decides its results.
    pub fn identity(&self) -> blake3::Hash {
        self.experiment.identities().of(self.seed)
    }

    /// Progress of the run, given whether it is finished.
    pub fn state(&self, is_done: bool) -> State {
        match Meta::read(&self.directory) {
            _ if is_done => State::Done,
            _ if is_locked(&self.directory) => State::Running,
            Some(meta) if meta.status == Status::Stopped => State::Stopped,
            _ => State::Interrupted,
        }
    }

    /// The record that it is finished. Its hash of the results agrees with the present files.
    ///
    /// # Errors
    /// Exit 5 if the configuration or a result was changed since, with everything that differs.
    pub fn done(&self) -> Result<Option<Done>> {
        let done = Done::read(&self.directory)?;
        if let Some(done) = &done {
            let results = self.experiment.results();
            done.check(self, |name| name == CONFIG || results.contains(&name))?;
        }
        Ok(done)
    }

    /// Returns the run if it is finished.
    ///
    /// # Errors
    /// Exit 1 if it isn't, exit 5 if the record of that is damaged.
    pub fn finished(&self) -> Result<Recorded<'_>> {
        let recorded = self.recorded()?;
        if !recorded.is_done {
            return Err(Failure::failed(format_args!(
                "{0}: is not finished, so it has no champion yet; `oneiro resume {0}` continues it",
                self.directory.display()
            )));
        }
        Ok(recorded)
    }

    /// Returns the recorded part of the run.
    ///
    /// # Errors
    /// Exit 5 if the record that it is finished is damaged.
    pub fn recorded(&self) -> Result<Recorded<'_>> {
        Ok(self.known(Done::read(&self.directory)?.is_some()))
    }

    /// A generation to look at, or the newest, while it may still be written; see [`Experiment::scene`].
    ///
    /// # Errors
    /// As there; exit 5 if the record that it is finished is damaged.
    pub fn scene(&self, generation: Option<u32>, engine: &Engine) -> Result<Option<Scene>> {
        let checkpoint = || newest_job(&self.directory, &self.identity());
        Arc::clone(&self.experiment).scene(&self.recorded()?, generation, &checkpoint, engine)
    }

    /// The run, given whether it is finished.
    pub fn known(&self, is_done: bool) -> Recorded<'_> {
        Recorded {
            directory: &self.directory,
            seed: self.seed,
            is_done,
        }
    }
}
