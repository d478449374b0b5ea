//! Runs and sweeps in notebooks, while they evolve.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use oneiro_host::api::{Task, watch as api};
use pyo3::prelude::*;

use crate::done;

/// Directories of runs and sweeps.
#[pyclass(frozen, module = "oneiro._native")]
pub(crate) struct View {
    view: Mutex<api::View>,
    task: Task,
}

impl View {
    fn view(&self) -> MutexGuard<'_, api::View> {
        self.view.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl View {
    #[new]
    fn new(py: Python<'_>, folders: Vec<PathBuf>) -> PyResult<Self> {
        let task = Task::default();
        let view = Mutex::new(done(py, || api::View::new(folders, &task))?);
        Ok(Self { view, task })
    }

    /// Looks at all directories. Returns whether all have ended, the curve, and the tables.
    fn look(&self, py: Python<'_>) -> (bool, String, String) {
        py.detach(|| {
            let mut view = self.view();
            let have_ended = view.look();
            let (curve, tables) = view.board();
            (have_ended, curve, tables)
        })
    }

    /// The newest best in words, and its episode's page.
    fn episode(&self, py: Python<'_>) -> PyResult<Option<(String, String)>> {
        done(py, || self.view().episode())
    }

    /// Ends a simulation, from another thread.
    fn stop(&self) {
        self.task.stop();
    }
}
