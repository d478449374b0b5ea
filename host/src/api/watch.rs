//! The curves, lists and episodes of `oneiro watch`, for a program that shows them elsewhere.

use std::path::PathBuf;

use super::{Result, Task};

/// Directories of runs and sweeps, unchanged until the next look.
pub struct View(oneiro_watch::View);

impl View {
    /// The folders are directories of runs or sweeps, or hold some. They may appear later. Stopping the task ends a simulation.
    ///
    /// # Errors
    /// Exit 4 if the CPU can't run the kernels.
    pub fn new(folders: Vec<PathBuf>, task: &Task) -> Result<Self> {
        Ok(Self(oneiro_watch::View::new(folders, &task.stop)?))
    }

    /// Looks at all directories, from now on with a low priority of this thread. Returns whether all have ended.
    pub fn look(&mut self) -> bool {
        self.0.look()
    }

    /// The newest run's curve as SVG, which may be empty, and tables of all as HTML.
    pub fn board(&self) -> (String, String) {
        (self.0.curve(), self.0.tables())
    }

    /// The newest run's newest best in words, and its episode's page, if there is one.
    ///
    /// # Errors
    /// Exit 5 if the run's files are damaged; exit 75 if the task was stopped.
    pub fn episode(&self) -> Result<Option<(String, String)>> {
        Ok(self.0.episode()?)
    }
}
