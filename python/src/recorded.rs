//! Runs and sweeps in directories.

use std::path::PathBuf;

use numpy::PyArray1;
use oneiro_host::api::{Task, recorded as api};
use pyo3::prelude::*;

use crate::experiment::Experiment;
use crate::{done, watched};

/// A run's directory.
#[pyclass(frozen, module = "oneiro._native")]
pub(crate) struct Run(api::Run);

#[pymethods]
impl Run {
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        done(py, || api::Run::open(&path)).map(Self)
    }

    #[getter]
    fn path(&self) -> PathBuf {
        self.0.directory().to_owned()
    }

    #[getter]
    fn table(&self) -> PathBuf {
        self.0.table()
    }

    #[getter]
    fn experiment(&self) -> Experiment {
        Experiment(self.0.experiment())
    }

    #[getter]
    fn seed(&self) -> u64 {
        self.0.seed()
    }

    #[getter]
    fn result(&self, py: Python<'_>) -> PyResult<Option<String>> {
        done(py, || self.0.result())
    }

    fn champion<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f32>>> {
        Ok(PyArray1::from_vec(py, done(py, || self.0.champion())?))
    }

    fn verify(&self, py: Python<'_>) -> PyResult<String> {
        done(py, || self.0.verify())
    }

    fn replay(&self, py: Python<'_>, out: PathBuf, trial: u32, seed: Option<u64>, backend: &str) -> PyResult<()> {
        let (task, out) = (Task::default(), &out);
        let replayed = api::Replayed { trial, seed, out };
        watched(py, &task, None, || self.0.replay(replayed, backend, &task))
    }

    fn audit(&self, py: Python<'_>, share: f64, backend: &str) -> PyResult<String> {
        let task = Task::default();
        watched(py, &task, None, || self.0.audit(share, backend, &task))
    }
}

/// Runs an experiment with a seed.
#[pyfunction]
pub(crate) fn run(
    py: Python<'_>,
    experiment: &Bound<'_, Experiment>,
    seed: u64,
    out: PathBuf,
    backend: &str,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Run> {
    let (experiment, task) = (&experiment.get().0, Task::default());
    watched(py, &task, progress, || api::run(experiment, seed, &out, backend, &task)).map(Run)
}

/// Goes on with a run.
#[pyfunction]
pub(crate) fn resume(
    py: Python<'_>,
    path: PathBuf,
    backend: &str,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Run> {
    let task = Task::default();
    watched(py, &task, progress, || api::resume(&path, backend, &task)).map(Run)
}

/// A sweep's tables: the number of its runs, the hash of its tables, and the files.
type Tables = (usize, String, Vec<PathBuf>);

fn tables(api::Tables { runs, hash, files }: api::Tables) -> Tables {
    (runs, hash, files)
}

/// Does a sweep, or a shard of it, which has no tables.
#[pyfunction]
pub(crate) fn sweep(
    py: Python<'_>,
    plan: PathBuf,
    out: PathBuf,
    shard: Option<&str>,
    jobs: Option<u32>,
    backend: &str,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Option<Tables>> {
    let task = Task::default();
    let shard = done(py, || shard.map(api::SweepShard::parse).transpose())?;
    let own = watched(py, &task, progress, || {
        api::sweep(&plan, &out, shard, jobs, backend, &task)
    })?;
    Ok(own.map(tables))
}

/// Makes the tables of a sweep of its shards.
#[pyfunction]
pub(crate) fn merge(py: Python<'_>, directories: Vec<PathBuf>, out: Option<PathBuf>) -> PyResult<Tables> {
    done(py, || api::merge(&directories, out.as_deref())).map(tables)
}
