//! The champions of a sweep, read from its tables.

use std::path::{Path, PathBuf};

use oneiro::world::GeneLayout;
use oneiro_base::exit::{Failure, Result};
use oneiro_evolve::Population;

use super::store::Store;
use super::{Plan, Sweep, contents, tables};
use crate::genomes;

/// A finished sweep of single robots.
#[derive(Debug)]
pub struct Champions {
    pub sweep: Sweep,
    plan: Plan,
    /// The table.
    path: PathBuf,
}

impl Champions {
    /// Opens a sweep's directory.
    ///
    /// # Errors
    /// Exit 3 if this program can't read it, if its runs are of swarms, or if it has no tables yet.
    pub fn open(directory: &Path) -> Result<Self> {
        let (sweep, plan) = Store::open(directory)?.sweep()?;
        let refused = |problem: &str| Err(Failure::input(format_args!("{}: {problem}", directory.display())));
        if plan.layouts.contains(&None) {
            return refused(
                "is a sweep of the foraging study, whose controllers evolve together; allowed: sweeps of other experiments",
            );
        }
        let path = tables::table(directory, contents::CHAMPIONS)?;
        Ok(Self { sweep, plan, path })
    }

    /// The file that has them: a row for each run, in the order of the runs.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// All of them, for a controller.
    ///
    /// # Errors
    /// Exit 3 if a run's controller has other genes, or if the file isn't what was written.
    pub fn genomes(&self, layout: &GeneLayout) -> Result<Population> {
        for own in self.plan.layouts.iter().flatten() {
            genomes::check_names(&self.path, own, layout)?;
        }
        genomes::read(&self.path, layout, drop)
    }
}
