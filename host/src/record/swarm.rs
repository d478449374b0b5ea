//! The directory of a swarm's run. Such a run lasts seconds; one that was stopped is done again from its beginning.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use super::recorder::lock;
use super::saved::{seed_of, state};
use super::{CONFIG, Done, Meta, Session, Standing, State, Status, disk, done, is_run, standing};
use crate::exit::{Failure, Result};
use crate::experiment::swarm::{SwarmExperiment, is_swarm};
use crate::swarm::lived::Run;
use crate::swarm::tables::{FOOD, INTERVALS, INTERVALS_HEAD};

/// Whether a directory is that of a swarm's run.
pub(crate) fn is_swarm_run(directory: &Path) -> bool {
    is_run(directory) && is_swarm(&directory.join(CONFIG)).unwrap_or(false)
}

/// Writes a run's directory; as long as it lives, no other process does.
#[derive(Debug)]
pub(crate) struct SwarmRecorder {
    directory: PathBuf,
    _lock: File,
    identity: blake3::Hash,
    meta: Meta,
}

impl SwarmRecorder {
    /// Starts a run's directory, or starts anew with one that was stopped.
    ///
    /// # Errors
    /// Exit 3 when something else stands there, or another process writes there; exit 6 when writing fails.
    pub(crate) fn begin(directory: &Path, experiment: &SwarmExperiment, seed: u64, session: Session) -> Result<Self> {
        fs::create_dir_all(directory).map_err(|error| Failure::storage(directory, &error))?;
        let lock = lock(directory)?;
        let identity = experiment.identity(seed);
        if let Standing::Done(_) = standing(directory, identity)? {
            return Err(Failure::input(format_args!(
                "{}: another process has done this run",
                directory.display()
            )));
        }
        disk::write(&directory.join(CONFIG), experiment.resolved_toml(seed).as_bytes())?;
        disk::sync_directory(directory)?;
        let minutes = experiment.settings().minutes;
        let meta = Meta::begin(directory, experiment.name(), seed, minutes, session)?;
        Ok(Self {
            directory: directory.to_owned(),
            _lock: lock,
            identity,
            meta,
        })
    }

    /// Where it writes.
    pub(crate) fn directory(&self) -> &Path {
        &self.directory
    }

    /// Notes that it was stopped.
    pub(crate) fn stop(&mut self) -> Result {
        self.meta.end(&self.directory, Status::Stopped)
    }

    /// Writes the results, and `DONE` when all of them are on the disk.
    pub(crate) fn finish(&mut self, run: &Run) -> Result<Done> {
        disk::write(&self.directory.join(INTERVALS), intervals_csv(run).as_bytes())?;
        disk::write(&self.directory.join(FOOD), run.food_table().as_bytes())?;
        disk::sync_directory(&self.directory)?;
        let done = Done::of(&self.directory, self.identity, &[CONFIG, INTERVALS, FOOD])?;
        self.meta.generation = self.meta.generations;
        self.meta.best = Some(run.total() as f32);
        self.meta.end(&self.directory, Status::Done)?;
        done.write(&self.directory)?;
        Ok(done)
    }
}

/// The hash of a run's results, as its directory's `DONE` would have it, and its table of intervals without its first
/// line.
pub(crate) fn swarm_result(experiment: blake3::Hash, run: &Run) -> (String, String) {
    let table = intervals_csv(run);
    let food = run.food_table();
    let files = [(INTERVALS, table.as_bytes()), (FOOD, food.as_bytes())];
    let hash = done::result_of(experiment, &files);
    (hash, table[INTERVALS_HEAD.len()..].to_owned())
}

/// The whole table of intervals.
fn intervals_csv(run: &Run) -> String {
    INTERVALS_HEAD.to_owned() + &run.interval_rows()
}

/// A swarm's run as it is on the disk.
#[derive(Debug)]
pub(crate) struct SavedSwarm {
    directory: PathBuf,
    experiment: SwarmExperiment,
    seed: u64,
}

impl SavedSwarm {
    /// Opens a run's directory.
    ///
    /// # Errors
    /// Exit 3 when its configuration is invalid.
    pub(crate) fn open(directory: &Path) -> Result<Self> {
        let config = directory.join(CONFIG);
        let experiment = SwarmExperiment::read(&config, &[])?;
        let seed = seed_of(&config, experiment.seed())?;
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
    pub(crate) fn experiment(&self) -> &SwarmExperiment {
        &self.experiment
    }

    /// Its seed.
    pub(crate) fn seed(&self) -> u64 {
        self.seed
    }

    /// What decides its results.
    pub(crate) fn identity(&self) -> blake3::Hash {
        self.experiment.identity(self.seed)
    }

    /// How far it is.
    pub(crate) fn state(&self) -> Result<State> {
        state(&self.directory)
    }

    /// What is no result of it.
    pub(crate) fn meta(&self) -> Option<Meta> {
        Meta::read(&self.directory)
    }

    /// Refuses a run that is not finished.
    ///
    /// # Errors
    /// Exit 1.
    pub(crate) fn is_done(&self) -> Result {
        match Done::read(&self.directory)? {
            Some(_) => Ok(()),
            None => Err(self.failed("is not finished; `oneiro resume` does it again")),
        }
    }

    /// Whether a finished run is what was recorded.
    ///
    /// # Errors
    /// Exit 1 when it was another.
    pub(crate) fn compare(&self, run: &Run) -> Result {
        for (name, text) in [(INTERVALS, intervals_csv(run)), (FOOD, run.food_table())] {
            if disk::read_text(&self.directory.join(name))? != text {
                return Err(self.failed(&format!("{name} is not what this device computes")));
            }
        }
        Ok(())
    }

    fn failed(&self, problem: &str) -> Failure {
        Failure::failed(format_args!("{}: {problem}", self.directory.display()))
    }
}
