//! A finished run of single robots, read again.

use std::path::{Path, PathBuf};

use super::{POPULATION, champion};
use crate::evolve::{Champion, Population};
use crate::exit::{Failure, Result};
use crate::experiment::Experiment;
use crate::genomes;
use crate::record::SavedRun;

/// A run of single robots in its directory.
#[derive(Debug)]
pub(crate) struct SingleRun {
    run: SavedRun,
    experiment: Experiment,
}

impl SingleRun {
    /// Opens a run's directory.
    ///
    /// # Errors
    /// Exit 3 when it is none, when its configuration is invalid, or when it is the run of a swarm.
    pub(crate) fn open(directory: &Path) -> Result<Self> {
        let run = SavedRun::open(directory)?;
        if run.experiment().is_swarm() {
            return Err(Failure::input(format_args!(
                "{}: is the run of a swarm, whose controllers live among others; allowed: runs of single robots",
                directory.display()
            )));
        }
        let experiment = Experiment::read(&run.config(), &[])?;
        Ok(Self { run, experiment })
    }

    /// Where it is.
    pub(crate) fn directory(&self) -> &Path {
        self.run.directory()
    }

    /// The experiment's file, with every value written out.
    pub(crate) fn config(&self) -> PathBuf {
        self.run.config()
    }

    /// What it is a run of.
    pub(crate) fn experiment(&self) -> &Experiment {
        &self.experiment
    }

    /// Its champion.
    ///
    /// # Errors
    /// Exit 1 when the run is not finished, exit 5 when the files are not what was written.
    pub(crate) fn champion(&self) -> Result<Champion> {
        let recorded = self.run.finished()?;
        champion::read(recorded.directory, self.experiment.world().spec().controller)
    }

    /// Its last generation.
    ///
    /// # Errors
    /// As [`SingleRun::champion`].
    pub(crate) fn population(&self) -> Result<Population> {
        let recorded = self.run.finished()?;
        let controller = self.experiment.world().spec().controller;
        genomes::read(&recorded.directory.join(POPULATION), controller).map_err(Failure::corrupt)
    }
}
