//! Runs and sweeps in notebooks, while they evolve.

use std::path::PathBuf;

use oneiro_host::api::{Task, watch as api};
use pyo3::prelude::*;

use crate::{Shared, done};

/// Directories of runs and sweeps.
#[pyclass(frozen, module = "oneiro._native")]
pub(crate) struct View {
    view: Shared<api::View>,
    task: Task,
}

#[pymethods]
impl View {
    #[new]
    fn new(py: Python<'_>, folders: Vec<PathBuf>) -> PyResult<Self> {
        let task = Task::default();
        let view = Shared::new(done(py, || api::View::new(folders, &task))?);
        Ok(Self { view, task })
    }

    /// Looks at all directories. Returns whether all have ended, the curve, and the tables.
    fn look(&self, py: Python<'_>) -> (bool, String, String) {
        self.view.with(py, |view| {
            let have_ended = view.look();
            let (curve, tables) = view.board();
            (have_ended, curve, tables)
        })
    }

    /// The newest best in words, and its episode's page.
    fn episode(&self, py: Python<'_>) -> PyResult<Option<(String, String)>> {
        self.view.done(py, |view| view.episode())
    }

    /// Ends a simulation, from another thread.
    fn stop(&self) {
        self.task.stop();
    }
}
