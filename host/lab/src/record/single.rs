//! A finished run of single robots, read again.

use std::path::{Path, PathBuf};

use oneiro_base::exit::{Failure, Result};
use oneiro_evolve::{Champion, Population};

use super::SavedRun;
use crate::experiment::Experiment;
use crate::runs::single;

/// A run of single robots in its directory.
#[derive(Debug)]
pub struct SingleRun(SavedRun);

impl SingleRun {
    /// Opens a run's directory.
    ///
    /// # Errors
    /// Exit 3 if it isn't one, if its configuration is invalid, or if it is the run of a swarm.
    pub fn open(directory: &Path) -> Result<Self> {
        let run = Self(SavedRun::open(directory)?);
        run.experiment()?;
        Ok(run)
    }

    /// Path of the directory.
    pub fn directory(&self) -> &Path {
        self.0.directory()
    }

    /// Seed of the run.
    pub fn seed(&self) -> u64 {
        self.0.seed()
    }

    /// The experiment's file, with every value written out.
    pub fn config(&self) -> PathBuf {
        self.0.config()
    }

    /// Experiment of the run.
    ///
    /// # Errors
    /// Exit 3 if it is the run of a swarm.
    pub fn experiment(&self) -> Result<&Experiment> {
        self.0.experiment().single().ok_or_else(|| {
            Failure::input(format_args!(
                "{}: is a run of the foraging study, whose controllers evolve together; allowed: runs of other experiments",
                self.directory().display()
            ))
        })
    }

    /// The champion.
    ///
    /// # Errors
    /// Exit 1 if the run isn't finished, exit 5 if the files aren't what was written.
    pub fn champion(&self) -> Result<Champion> {
        single::champion(&self.0.finished()?, self.experiment()?)
    }

    /// The champion, the luckiest individual if there are finalists, and the last generation or every individual; each
    /// with its file.
    ///
    /// # Errors
    /// As [`SingleRun::champion`]; exit 1 if individuals are requested and were not recorded.
    pub fn all_genomes(&self, individuals: bool) -> Result<Vec<(&'static str, Population)>> {
        single::all_genomes(&self.0.finished()?, self.experiment()?, individuals)
    }

    /// The last generation.
    ///
    /// # Errors
    /// As [`SingleRun::champion`].
    pub fn population(&self) -> Result<Population> {
        single::population(&self.0.finished()?, self.experiment()?)
    }

    /// Whether it is finished.
    ///
    /// # Errors
    /// Exit 5 if the record of that is damaged.
    pub fn is_done(&self) -> Result<bool> {
        Ok(self.0.recorded()?.is_done)
    }
}
