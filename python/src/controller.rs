//! Controllers that are stepped with readings from elsewhere.

use std::path::Path;

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use oneiro::export::Input;
use oneiro_host::api::controller as api;
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::experiment::Experiment;
use crate::{Shared, class, done, raised};

/// The controllers of some robots.
#[pyclass(frozen, module = "oneiro._native")]
pub(crate) struct Controllers(Shared<api::Controllers>);

/// A row for each robot, of its left and its right motor.
fn pairs(py: Python<'_>, values: Vec<f32>) -> PyResult<Bound<'_, PyArray2<f32>>> {
    let robots = values.len() / 2;
    PyArray1::from_vec(py, values).reshape([robots, 2])
}

#[pymethods]
impl Controllers {
    #[new]
    fn new(
        py: Python<'_>,
        experiment: &Bound<'_, Experiment>,
        genomes: PyReadonlyArray2<'_, f32>,
        number: u32,
        robots: usize,
    ) -> PyResult<Self> {
        let (experiment, genomes) = (&experiment.get().0, genomes.as_slice()?);
        done(py, || api::Controllers::new(experiment, genomes, number, robots)).map(|own| Self(Shared::new(own)))
    }

    #[classmethod]
    fn _restored(
        _: &Bound<'_, PyType>,
        py: Python<'_>,
        experiment: &Bound<'_, Experiment>,
        genomes: Vec<f32>,
        number: u32,
        robots: usize,
        states: Vec<u32>,
    ) -> PyResult<Self> {
        let experiment = &experiment.get().0;
        let mut own = done(py, || api::Controllers::new(experiment, &genomes, number, robots))?;
        own.restore(&states).map_err(|error| raised(py, &error))?;
        Ok(Self(Shared::new(own)))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let arguments = self.0.with(py, |own| {
            let (experiment, genomes, number) = own.parts();
            let experiment = Experiment(experiment.clone());
            (experiment, genomes.to_vec(), number, own.robots(), own.states())
        });
        Ok((
            class::<Self>(py).getattr("_restored")?,
            arguments.into_pyobject(py)?.into_any(),
        ))
    }

    #[getter]
    fn experiment(&self, py: Python<'_>) -> Experiment {
        Experiment(self.0.with(py, |own| own.parts().0.clone()))
    }

    #[getter]
    fn kind(&self, py: Python<'_>) -> String {
        self.0.with(py, |own| own.kind().to_owned())
    }

    #[getter]
    fn robots(&self, py: Python<'_>) -> usize {
        self.0.with(py, |own| own.robots())
    }

    /// Name, and unit, range and meaning of each reading.
    #[getter]
    fn inputs(&self, py: Python<'_>) -> Vec<(String, String)> {
        let words = |input: &Input| (input.name.clone(), input.about.clone());
        self.0.with(py, |own| own.inputs().iter().map(words).collect())
    }

    fn export(
        &self,
        py: Python<'_>,
        to: &str,
        out: Option<&str>,
        name: Option<&str>,
        with: Vec<String>,
        checked: (u64, usize),
    ) -> PyResult<String> {
        let path = self.0.done(py, |own| {
            own.export(to, out.map(Path::new), name, &with, checked.0, checked.1)
        })?;
        Ok(path.display().to_string())
    }

    #[getter]
    fn cycles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        PyArray1::from_vec(py, self.0.with(py, |own| own.cycles()))
    }

    fn reset(&self, py: Python<'_>, seed: u64, numbers: PyReadonlyArray2<'_, u64>, episode: usize) -> PyResult<()> {
        let numbers = numbers.as_slice()?.as_chunks().0;
        self.0.with(py, |own| own.reset(seed, numbers, episode));
        Ok(())
    }

    fn step<'py>(&self, py: Python<'py>, readings: PyReadonlyArray1<'_, f32>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let readings = readings.as_slice()?;
        pairs(py, self.0.done(py, |own| own.step(readings))?)
    }

    fn wheels<'py>(&self, py: Python<'py>, outputs: PyReadonlyArray1<'_, f32>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let outputs = outputs.as_slice()?;
        pairs(py, self.0.done(py, |own| own.wheels(outputs))?)
    }
}
